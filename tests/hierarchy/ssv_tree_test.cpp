#include "bullet_ccd/hierarchy/ssv_tree.h"

#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;

Vector3d toVector(const float (&values)[3])
{
    return {values[0], values[1], values[2]};
}

Eigen::Matrix3d axesOf(const SsvNode& node)
{
    Eigen::Matrix3d axes;
    axes.col(0) = toVector(node.axis0);
    axes.col(1) = toVector(node.axis1);
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
}

/// Distance of `point` from the core as it is stored, by minimising over one coordinate at a time:
/// the axes are orthogonal up to single precision, so a few rounds are exact.
double distanceToCore(const SsvNode& node, const Vector3d& point)
{
    const Eigen::Matrix3d axes = axesOf(node);
    const Vector3d half = toVector(node.half);
    const Vector3d offset = point - toVector(node.center);
    Vector3d s = Vector3d::Zero();
    for (int round = 0; round < 6; ++round)
    {
        for (int k = 0; k < 3; ++k)
        {
            const Vector3d rest = offset - axes * s + s[k] * axes.col(k);
            const double best = axes.col(k).dot(rest) / axes.col(k).squaredNorm();
            s[k] = std::clamp(best, -half[k], half[k]);
        }
    }
    return (offset - axes * s).norm();
}

struct TreeCheck
{
    int depth = 0;
    std::vector<int> leavesOfTriangle;
    double worstEscape = -std::numeric_limits<double>::infinity();  ///< relative to the node's size
    double worstCoreRadius = -std::numeric_limits<double>::infinity();
    std::size_t visited = 0;
};

/// Largest distance of a corner of the core from its centre.
double coreRadius(const SsvNode& node)
{
    const Eigen::Matrix3d axes = axesOf(node);
    double radius = 0.0;
    for (int bits = 0; bits < 8; ++bits)
    {
        Vector3d corner = Vector3d::Zero();
        for (int k = 0; k < 3; ++k)
        {
            const double sign = ((bits >> k) & 1) != 0 ? 1.0 : -1.0;
            corner += sign * static_cast<double>(node.half[k]) * axes.col(k);
        }
        radius = std::max(radius, corner.norm());
    }
    return radius;
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
        EXPECT_GE(node.count, 2);
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
    const double radius = shrink * static_cast<double>(node.radius);
    const double size =
        1e-300 + static_cast<double>(node.radius + node.half[0] + node.half[1] + node.half[2]);
    for (const std::int32_t triangleIndex : below)
    {
        for (const Vector3d& corner : tree.cornersOfTriangle(triangleIndex))
        {
            const double escape = distanceToCore(tested, corner) - radius;
            // Double rounding of this check itself is far below the rounding of single precision.
            const double slack = 1e-14 * corner.norm();
            check.worstEscape = std::max(check.worstEscape, (escape - slack) / size);
        }
    }
    return below;
}

TreeCheck checkTree(const SsvTree& tree, double shrink = 1.0)
{
    TreeCheck check;
    check.leavesOfTriangle.assign(tree.mesh().triangles.size(), 0);
    visit(tree, 0, shrink, 0, check);
    return check;
}

void expectSound(const SsvTree& tree, const std::string& what)
{
    const TreeCheck check = checkTree(tree);
    const std::size_t count = tree.mesh().triangles.size();
    EXPECT_LE(check.worstEscape, 0.0) << what;
    EXPECT_LE(check.worstCoreRadius, 0.0) << what;
    EXPECT_EQ(check.visited, tree.nodes().size()) << what;
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

double logOf(const SsvTree& tree)
{
    return std::log2(static_cast<double>(tree.mesh().triangles.size()));
}

TEST(SsvTree, ContainsItsTrianglesAndSplitsThemIntoLeaves)
{
    Random random(1);
    expectSound(buildSsvTree(triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})), "one triangle");
    expectSound(buildSsvTree(cube(1.0)), "cube");
    expectSound(buildSsvTree(octahedron()), "octahedron");
    expectSound(buildSsvTree(floorAt(0.0, 1e3)), "plate");
    expectSound(buildSsvTree(sphereWithPole(0.3, {1, 2, 3}, 16)), "sphere");
    expectSound(buildSsvTree(prism(circlePoints(1.0, circleAngles(64, 0.1)), -3, 3)), "prism");
    for (int i = 0; i < 60; ++i)
    {
        const double scale = random.logUniform(1e-6, 1e6);
        const double offset = random.chance(0.5) ? 0.0 : random.logUniform(1.0, 1e4);
        TriangleMesh mesh = soup(random, random.integer(1, 200), 1.0, random.logUniform(1e-4, 1.0));
        mesh = scaled(shifted(mesh, offset * random.direction()), scale);
        expectSound(buildSsvTree(placed(mesh, poseOf(Vector3d::Zero(), 1.0, {1, 2, 3}))),
                    "soup " + std::to_string(i));
    }
}

TEST(SsvTree, ContainsDegenerateTriangles)
{
    Random random(2);
    expectSound(buildSsvTree(segment({0, 0, 0}, {1, 2, 3})), "segment");
    expectSound(buildSsvTree(triangle({1, 2, 3}, {1, 2, 3}, {1, 2, 3})), "point");
    TriangleMesh needles;
    for (std::int32_t i = 0; i < 100; ++i)
    {
        const Vector3d start = random.inBox(1.0);
        const Vector3d along = random.direction();
        needles.vertices.insert(needles.vertices.end(),
                                {start, start + along, start + along + 1e-9 * random.direction()});
        needles.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    expectSound(buildSsvTree(needles), "needles");
}

TEST(SsvTree, VolumesThatAreTooSmallByOnePercentAreNoticed)
{
    Random random(3);
    for (int i = 0; i < 10; ++i)
    {
        const SsvTree tree = buildSsvTree(soup(random, 50, 1.0, 0.2));
        EXPECT_GT(checkTree(tree, 0.99).worstEscape, 1e-4);
    }
}

TEST(SsvTree, VolumesAreNotWastefullyLarge)
{
    const SsvTree tree = buildSsvTree(box({-3, -2, -1}, {3, 2, 1}));
    const SsvNode& root = tree.nodes()[0];
    const double reach = Vector3d(root.half[0], root.half[1], root.half[2]).norm() +
                         static_cast<double>(root.radius);
    EXPECT_LT(reach, 1.5 * Vector3d(3, 2, 1).norm());
}

TEST(SsvTree, DepthStaysLogarithmicForEqualCentroids)
{
    Random random(4);
    TriangleMesh concentric;
    for (std::int32_t i = 0; i < 1000; ++i)
    {
        const Vector3d a = random.inBox(1.0);
        const Vector3d b = random.inBox(1.0);
        concentric.vertices.insert(concentric.vertices.end(), {a, b, -a - b});
        concentric.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    TriangleMesh same = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    same.triangles.assign(1000, same.triangles[0]);
    for (const TriangleMesh& mesh : {concentric, same})
    {
        const SsvTree tree = buildSsvTree(mesh);
        expectSound(tree, "equal centroids");
        EXPECT_LE(checkTree(tree).depth, static_cast<int>(2.0 * logOf(tree)) + 4);
    }
}

TEST(SsvTree, DepthStaysModestForExponentialSpacing)
{
    TriangleMesh mesh;
    for (std::int32_t i = 0; i < 1000; ++i)
    {
        const double x = std::pow(2.0, -i / 2);
        mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x, 0.5 * x, 0}, {x, 0, 0.5 * x}});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const SsvTree tree = buildSsvTree(mesh);
    expectSound(tree, "exponential spacing");
    EXPECT_LE(checkTree(tree).depth, 64);
}

TEST(SsvTree, IsTheSameEveryTime)
{
    Random random(5);
    const TriangleMesh mesh = soup(random, 200, 1.0, 0.2);
    const SsvTree first = buildSsvTree(mesh);
    const SsvTree second = buildSsvTree(mesh);
    ASSERT_EQ(first.nodes().size(), second.nodes().size());
    for (std::size_t i = 0; i < first.nodes().size(); ++i)
    {
        EXPECT_EQ(first.nodes()[i].first, second.nodes()[i].first);
        EXPECT_EQ(first.nodes()[i].count, second.nodes()[i].count);
        EXPECT_EQ(first.nodes()[i].radius, second.nodes()[i].radius);
    }
}

TEST(SsvTree, RejectsWhatCannotBeAMesh)
{
    EXPECT_THROW((void)buildSsvTree({}), std::invalid_argument);
    TriangleMesh mesh = cube(1.0);
    mesh.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)buildSsvTree(mesh), std::invalid_argument);
    mesh.vertices[3].y() = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)buildSsvTree(mesh), std::invalid_argument);
    mesh = cube(1.0);
    mesh.triangles[5][1] = 8;
    EXPECT_THROW((void)buildSsvTree(mesh), std::invalid_argument);
    mesh.triangles[5][1] = -1;
    EXPECT_THROW((void)buildSsvTree(mesh), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::tests
