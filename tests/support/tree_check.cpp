#include "tests/support/tree_check.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Matrix3l = Eigen::Matrix<long double, 3, 3>;

Vector3l toVector(const float (&values)[3])
{
    return {values[0], values[1], values[2]};
}

Matrix3l axesOf(const SsvNode& node)
{
    Matrix3l axes;
    axes.col(0) = toVector(node.axis0);
    axes.col(1) = toVector(node.axis1);
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
}

/// Distance of `point` from the core as it is stored, by minimising over one coordinate at a time:
/// the axes are orthogonal up to single precision, so a few rounds are exact.
long double distanceToCore(const SsvNode& node, const Vector3l& point)
{
    const Matrix3l axes = axesOf(node);
    const Vector3l half = toVector(node.half);
    const Vector3l offset = point - toVector(node.center);
    Vector3l s = Vector3l::Zero();
    for (int round = 0; round < 4; ++round)
    {
        for (int k = 0; k < 3; ++k)
        {
            const Vector3l rest = offset - axes * s + s[k] * axes.col(k);
            const long double best = axes.col(k).dot(rest) / axes.col(k).squaredNorm();
            s[k] = std::clamp(best, -half[k], half[k]);
        }
    }
    return (offset - axes * s).norm();
}

/// Largest distance of a corner of the core from its centre.
double coreRadius(const SsvNode& node)
{
    const Matrix3l axes = axesOf(node);
    const Vector3l half = toVector(node.half);
    long double radius = 0.0L;
    for (int bits = 0; bits < 8; ++bits)
    {
        Vector3l corner = Vector3l::Zero();
        for (int k = 0; k < 3; ++k)
        {
            corner += (((bits >> k) & 1) != 0 ? half[k] : -half[k]) * axes.col(k);
        }
        radius = std::max(radius, corner.norm());
    }
    return static_cast<double>(radius);
}

/// Visits the subtree, checks every node against the triangles below it, and returns them.
std::vector<std::int32_t> visit(
    const SsvTree& tree, std::int32_t index, double shrink, int depth, TreeCheck& check)
{
    const SsvNode& node = tree.nodes()[static_cast<std::size_t>(index)];
    ++check.visited;
    check.depth = std::max(check.depth, depth);
    check.worstCoreRadius =
        std::max(check.worstCoreRadius,
                 coreRadius(node) - (1.0 + 3e-7) * static_cast<double>(node.coreRadius));
    std::vector<std::int32_t> below;
    if (node.isLeaf())
    {
        below.push_back(tree.triangle(node.first));
        ++check.leavesOfTriangle.at(static_cast<std::size_t>(below.back()));
    }
    else
    {
        EXPECT_GE(node.count, 1);
        check.doors += node.count == 1 ? 1 : 0;
        tree.open(node);
        EXPECT_LE(node.count, kArity);
        for (std::int32_t k = 0; k < node.count; ++k)
        {
            const auto child = visit(tree, node.first + k, shrink, depth + 1, check);
            below.insert(below.end(), child.begin(), child.end());
        }
    }
    SsvNode tested = node;
    for (float& half : tested.half)
    {
        half *= static_cast<float>(shrink);
    }
    const long double radius = static_cast<long double>(shrink) * node.radius;
    const long double size = 1e-300L + node.radius + node.half[0] + node.half[1] + node.half[2];
    for (const std::int32_t triangleIndex : below)
    {
        for (const Vector3d& corner : tree.cornersOfTriangle(triangleIndex))
        {
            const long double escape = distanceToCore(tested, corner.cast<long double>()) - radius;
            // Rounding of this check itself, a thousand times finer than that of double precision.
            const long double slack = 1e-18L * (corner.norm() + size);
            check.worstEscape =
                std::max(check.worstEscape, static_cast<double>((escape - slack) / size));
        }
    }
    return below;
}

RigidMotion randomPass(reference::Random& random)
{
    const Vector3d from = random.direction();
    RigidMotion motion;
    motion.X_W0.linear() = random.rotation();
    motion.X_W0.translation() = 3.5 * from;
    motion.v_W = -4.0 * from + 3.0 * random.direction();
    motion.w_W = 2.0 * random.direction();
    return motion;
}

}  // namespace

TreeCheck checkTree(const SsvTree& tree, double shrink)
{
    TreeCheck check;
    check.leavesOfTriangle.assign(tree.mesh().triangles.size(), 0);
    visit(tree, 0, shrink, 0, check);
    return check;
}

void expectSoundTree(const SsvTree& tree, const std::string& what)
{
    const TreeCheck check = checkTree(tree);
    const std::size_t count = tree.mesh().triangles.size();
    EXPECT_LE(check.worstEscape, 0.0) << what;
    EXPECT_LE(check.worstCoreRadius, 0.0) << what;
    EXPECT_EQ(check.visited, tree.nodes().size()) << what;
    EXPECT_EQ(check.doors, 0u) << what;
    EXPECT_LE(tree.nodes().size(), 2 * count - 1) << what;
    EXPECT_TRUE(std::all_of(check.leavesOfTriangle.begin(),
                            check.leavesOfTriangle.end(),
                            [](int leaves) { return leaves == 1; }))
        << what;
    double radius = 0.0;
    for (std::size_t i = 0; i < count; ++i)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto index = static_cast<std::size_t>(tree.mesh().triangles[i][k]);
            const Vector3d expected = tree.mesh().vertices[index] - tree.origin();
            EXPECT_EQ(tree.cornersOfTriangle(static_cast<std::int32_t>(i))[k], expected) << what;
            radius = std::max(radius, expected.norm());
        }
    }
    EXPECT_DOUBLE_EQ(tree.radius(), radius) << what;
}

void expectSameAnswers(const SsvTree& a, const SsvTree& b, reference::Random& random, int queries)
{
    constexpr double kTolerance = 1e-6;
    int hits = 0;
    ToiWorkspace work;
    for (int i = 0; i < queries; ++i)
    {
        const RigidMotion motion = randomPass(random);
        const auto distance = [&](const SsvTree& tree, double t)
        { return treeDistance(tree, tree, motion.at(t).X_W, 100.0).distance; };
        EXPECT_NEAR(distance(a, 0.2), distance(b, 0.2), 1e-12);
        const auto toi = [&](const SsvTree& tree)
        {
            return rigidToi({.tree = &tree, .motion = motion},
                            {.tree = &tree, .motion = restAt(Eigen::Isometry3d::Identity())},
                            {.tolerance = kTolerance},
                            work);
        };
        const ToiResult fromA = toi(a);
        const ToiResult fromB = toi(b);
        EXPECT_EQ(fromA.status, fromB.status);
        if (fromA.status == ToiStatus::Hit)
        {
            ++hits;
            EXPECT_NEAR(distance(a, fromB.time), 0.0, kTolerance);
            EXPECT_GT(distance(a, fromB.time), 0.0);
            EXPECT_NEAR(fromA.time, fromB.time, 1e-3);
        }
    }
    EXPECT_GT(hits, queries / 5);
    EXPECT_LT(hits, queries);
}
}  // namespace bullet_ccd::tests
