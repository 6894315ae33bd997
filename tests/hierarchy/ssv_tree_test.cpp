#include "bullet_ccd/hierarchy/ssv_tree.h"

#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/mesh/make_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <oneapi/tbb/global_control.h>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Matrix3l = Eigen::Matrix<long double, 3, 3>;

constexpr SsvKind kKinds[] = {SsvKind::Box,
                              SsvKind::RoundedBox,
                              SsvKind::SweptRectangle,
                              SsvKind::SweptLine,
                              SsvKind::SweptPoint,
                              SsvKind::Cheapest};

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

/// At least how many half-extents are zero.
int missingDimensions(SsvKind kind)
{
    switch (kind)
    {
        case SsvKind::SweptPoint:
            return 3;
        case SsvKind::SweptLine:
            return 2;
        case SsvKind::SweptRectangle:
            return 1;
        default:
            return 0;
    }
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
    EXPECT_GE(std::count(std::begin(node.half), std::end(node.half), 0.0F),
              missingDimensions(tree.options().kind));
    if (tree.options().kind == SsvKind::Box)
    {
        EXPECT_EQ(node.radius, 0.0F);
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

TreeCheck checkTree(const SsvTree& tree, double shrink = 1.0)
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

void expectSound(const TriangleMesh& mesh, const std::string& what)
{
    for (const SsvKind kind : kKinds)
    {
        expectSoundTree(buildSsvTree(mesh, {.kind = kind}),
                        what + ", kind " + std::to_string(static_cast<int>(kind)));
    }
}

double logOf(const SsvTree& tree)
{
    return std::log2(static_cast<double>(tree.mesh().triangles.size()));
}

TEST(SsvTree, ContainsItsTrianglesAndSplitsThemIntoLeaves)
{
    Random random(1);
    expectSound(triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), "one triangle");
    expectSound(cube(1.0), "cube");
    expectSound(octahedron(), "octahedron");
    expectSound(floorAt(0.0, 1e3), "plate");
    expectSound(sphereWithPole(0.3, {1, 2, 3}, 16), "sphere");
    expectSound(prism(circlePoints(1.0, circleAngles(64, 0.1)), -3, 3), "prism");
    for (int i = 0; i < 30; ++i)
    {
        const double scale = random.logUniform(1e-6, 1e6);
        const double offset = random.chance(0.5) ? 0.0 : random.logUniform(1.0, 1e4);
        TriangleMesh mesh = soup(random, random.integer(1, 200), 1.0, random.logUniform(1e-4, 1.0));
        mesh = scaled(shifted(mesh, offset * random.direction()), scale);
        expectSound(placed(mesh, poseOf(Vector3d::Zero(), 1.0, {1, 2, 3})),
                    "soup " + std::to_string(i));
    }
}

TEST(SsvTree, ContainsDegenerateTriangles)
{
    Random random(2);
    expectSound(segment({0, 0, 0}, {1, 2, 3}), "segment");
    expectSound(triangle({1, 2, 3}, {1, 2, 3}, {1, 2, 3}), "point");
    TriangleMesh needles;
    for (std::int32_t i = 0; i < 100; ++i)
    {
        const Vector3d start = random.inBox(1.0);
        const Vector3d along = random.direction();
        needles.vertices.insert(needles.vertices.end(),
                                {start, start + along, start + along + 1e-9 * random.direction()});
        needles.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    expectSound(needles, "needles");
}

TEST(SsvTree, VolumesThatAreTooSmallByOnePercentAreNoticed)
{
    Random random(3);
    for (int i = 0; i < 10; ++i)
    {
        const TriangleMesh mesh = soup(random, 50, 1.0, 0.2);
        for (const SsvKind kind : kKinds)
        {
            EXPECT_GT(checkTree(buildSsvTree(mesh, {.kind = kind}), 0.99).worstEscape, 1e-4);
        }
    }
}

TEST(SsvTree, VolumesAreNotWastefullyLarge)
{
    const TriangleMesh mesh = placed(box({-3, -2, -1}, {3, 2, 1}), poseOf({7, 8, 9}, 1.0));
    const double corner = Vector3d(3, 2, 1).norm();
    const auto rootOf = [&](SsvKind kind) { return buildSsvTree(mesh, {.kind = kind}).nodes()[0]; };
    // A box in a box: its own half-extents, whatever way it lies.
    const SsvNode exact = rootOf(SsvKind::Box);
    EXPECT_NEAR(exact.half[0], 3.0, 0.1);
    EXPECT_NEAR(exact.half[1], 2.0, 0.1);
    EXPECT_NEAR(exact.half[2], 1.0, 0.1);
    // The ball of a box is about its corners; all others are between the two.
    EXPECT_NEAR(static_cast<double>(rootOf(SsvKind::SweptPoint).radius), corner, 0.1);
    EXPECT_NEAR(static_cast<double>(rootOf(SsvKind::SweptRectangle).radius), 1.0, 0.1);
    EXPECT_NEAR(static_cast<double>(rootOf(SsvKind::SweptLine).radius), std::sqrt(5.0), 0.2);
    for (const SsvKind kind : kKinds)
    {
        EXPECT_LT(static_cast<double>(rootOf(kind).size()), 1.7 * corner);
    }
}

TEST(SsvTree, CheapestTakesTheSimplestCoreThatIsTight)
{
    const auto rootOf = [](const TriangleMesh& mesh)
    { return buildSsvTree(mesh, {.kind = SsvKind::Cheapest}).nodes()[0]; };
    const auto coreDimensions = [](const SsvNode& node)
    {
        return 3 - std::count_if(std::begin(node.half),
                                 std::end(node.half),
                                 [&](float half) { return half <= 0.02F * node.size(); });
    };
    EXPECT_EQ(coreDimensions(rootOf(makeSphere(1.0, 3))), 0);
    EXPECT_EQ(coreDimensions(rootOf(makeCapsule(0.5, 4.0, 32))), 1);
    EXPECT_EQ(coreDimensions(rootOf(box({-5, -4, -0.1}, {5, 4, 0.1}))), 2);
    EXPECT_EQ(coreDimensions(rootOf(box({-5, -4, -3}, {5, 4, 3}))), 3);
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
        expectSoundTree(tree, "equal centroids");
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
    expectSoundTree(tree, "exponential spacing");
    EXPECT_LE(checkTree(tree).depth, 64);
}

TEST(SsvTree, IsTheSameForAnyNumberOfThreads)
{
    const TriangleMesh mesh = makeSphere(1.0, 5);
    for (const SsvKind kind : kKinds)
    {
        const auto build = [&](std::size_t threads)
        {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            return buildSsvTree(mesh, {.kind = kind});
        };
        const SsvTree first = build(1);
        for (const std::size_t threads : {2, 3, 8})
        {
            const SsvTree second = build(threads);
            ASSERT_EQ(first.nodes().size(), second.nodes().size());
            EXPECT_EQ(std::memcmp(
                          first.nodes().data(), second.nodes().data(), first.nodes().size_bytes()),
                      0);
            for (std::int32_t slot = 0; slot < 20 * 1024; ++slot)
            {
                ASSERT_EQ(first.triangle(slot), second.triangle(slot));
            }
        }
    }
}

std::vector<Vector3d> deformed(const std::vector<Vector3d>& vertices, Random& random)
{
    const double bend = random.uniform(0.2, 2.0);
    const double noise = random.logUniform(1e-4, 0.2);
    const Vector3d shift = random.inBox(10.0);
    std::vector<Vector3d> moved;
    for (const Vector3d& p : vertices)
    {
        moved.emplace_back(shift +
                           Vector3d(p.x() * std::cos(bend * p.z()),
                                    p.y() + std::sin(bend * p.x()),
                                    p.z() * (1.0 + 0.3 * p.y())) +
                           random.inBox(noise));
    }
    return moved;
}

TEST(SsvTree, RefitContainsTheTrianglesOfADeformedMesh)
{
    Random random(6);
    for (int i = 0; i < 20; ++i)
    {
        const TriangleMesh mesh =
            i % 2 == 0 ? makeSphere(1.0, 2) : soup(random, random.integer(1, 200), 1.0, 0.2);
        for (const SsvKind kind : kKinds)
        {
            SsvTree tree = buildSsvTree(mesh, {.kind = kind});
            const std::vector<SsvNode> before(tree.nodes().begin(), tree.nodes().end());
            const std::vector<Vector3d> vertices = deformed(mesh.vertices, random);
            tree.refit(vertices);
            expectSoundTree(tree, "deformed " + std::to_string(i));
            EXPECT_EQ(tree.mesh().vertices, vertices);
            EXPECT_EQ(tree.options().kind, kind);
            for (std::size_t k = 0; k < before.size(); ++k)
            {
                EXPECT_EQ(tree.nodes()[k].first, before[k].first);
                EXPECT_EQ(tree.nodes()[k].count, before[k].count);
            }
        }
    }
}

TEST(SsvTree, RefitWithTheSameVerticesGivesTheSameBits)
{
    const SsvTree built = buildSsvTree(makeTorus(1.0, 0.3, 40, 20));
    SsvTree tree = built;
    Random random(7);
    tree.refit(deformed(built.mesh().vertices, random));
    EXPECT_NE(std::memcmp(tree.nodes().data(), built.nodes().data(), built.nodes().size_bytes()),
              0);
    tree.refit(built.mesh().vertices);
    EXPECT_EQ(std::memcmp(tree.nodes().data(), built.nodes().data(), built.nodes().size_bytes()),
              0);
}

TEST(SsvTree, RefitRejectsVerticesThatDoNotFitAndStaysAsItWas)
{
    SsvTree tree = buildSsvTree(cube(1.0));
    std::vector<Vector3d> vertices = tree.mesh().vertices;
    vertices.pop_back();
    EXPECT_THROW(tree.refit(vertices), std::invalid_argument);
    vertices.emplace_back(0.0, 0.0, std::numeric_limits<double>::quiet_NaN());
    EXPECT_THROW(tree.refit(vertices), std::invalid_argument);
    EXPECT_EQ(tree.mesh().vertices, cube(1.0).vertices);
    expectSoundTree(tree, "after refused refits");
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
