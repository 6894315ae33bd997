#include "bullet_ccd/hierarchy/ssv_tree.h"

#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/hierarchy/ssv_axes.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/flat_plate.h"
#include "tests/support/tree_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <malloc.h>
#include <oneapi/tbb/global_control.h>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

void expectSound(const TriangleMesh& mesh, const std::string& what)
{
    expectSoundTree(buildSsvTree(mesh), what);
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

TEST(SsvTree, ContainsItsTrianglesAtTheEndsOfSinglePrecision)
{
    Random random(5);
    for (const double scale : {1e-15, 1e-9, 1e9, 1e15})
    {
        expectSound(scaled(soup(random, 300, 1.0, 0.1), scale), "scale " + std::to_string(scale));
        // Crowds far smaller than the whole, at its origin and away from it.
        TriangleMesh mesh = soup(random, 5, 1.0, 1.0);
        for (const double size : {1e-9, 1e-18, 1e-27})
        {
            mesh = merged({mesh,
                           scaled(soup(random, 100, 1.0, 0.1), size),
                           shifted(scaled(soup(random, 100, 1.0, 0.1), size), {0.3, 0.2, 0.1})});
        }
        expectSound(scaled(mesh, scale), "crowds, scale " + std::to_string(scale));
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
        EXPECT_GT(checkTree(buildSsvTree(mesh), 0.99).worstEscape, 1e-4);
    }
}

TEST(SsvTree, VolumesAreNotWastefullyLarge)
{
    // A box in a box: its own half-extents, whatever way it lies.
    const TriangleMesh slab = placed(box({-3, -2, -0.01}, {3, 2, 0.01}), poseOf({7, 8, 9}, 1.0));
    const SsvNode flat = buildSsvTree(slab).nodes()[0];
    EXPECT_NEAR(flat.half[0], 3.0, 0.1);
    EXPECT_NEAR(flat.half[1], 2.0, 0.1);
    EXPECT_NEAR(flat.half[2], 0.01, 0.001);
    EXPECT_EQ(flat.radius, 0.0F);
    const TriangleMesh brick = placed(box({-3, -2, -1}, {3, 2, 1}), poseOf({7, 8, 9}, 1.0));
    const double corner = Vector3d(3, 2, 1).norm();
    EXPECT_LT(static_cast<double>(buildSsvTree(brick).nodes()[0].size()), 1.1 * corner);
    // The box about a ball would reach 1.7 times as far.
    EXPECT_LT(static_cast<double>(buildSsvTree(makeSphere(1.0, 3)).nodes()[0].size()), 1.35);
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
    const auto build = [&](std::size_t threads)
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return buildSsvTree(mesh);
    };
    const SsvTree first = build(1);
    for (const std::size_t threads : {2, 3, 8})
    {
        const SsvTree second = build(threads);
        ASSERT_EQ(first.nodes().size(), second.nodes().size());
        EXPECT_EQ(
            std::memcmp(first.nodes().data(), second.nodes().data(), first.nodes().size_bytes()),
            0);
        for (std::int32_t slot = 0; slot < 20 * 1024; ++slot)
        {
            ASSERT_EQ(first.triangle(slot), second.triangle(slot));
        }
    }
}

/// Which sets are turned together is a matter of how the work is shared out.
TEST(SsvTree, BoxesThatAreTurnedAtOnceDoNotDependOnEachOther)
{
    Random random(3);
    int turned = 0;
    for (int i = 0; i < 300; ++i)
    {
        std::array<SsvPoints, kSsvTurnedAtOnce> sets;
        std::array<SsvAxes, kSsvTurnedAtOnce> starts;
        for (std::size_t k = 0; k < sets.size(); ++k)
        {
            const Vector3d size(1.0, random.logUniform(1e-3, 1.0), random.logUniform(1e-3, 1.0));
            std::vector<Vector3d> points;
            for (int count = random.integer(3, 60); count > 0; --count)
            {
                points.emplace_back(size.cwiseProduct(random.inBox(1.0)));
            }
            sets[k].begin(points[0], points.size());
            sets[k].add(points);
            sets[k].end();
            const Eigen::Matrix3f R = random.rotation().cast<float>();
            starts[k] = {.axis0 = R.col(0), .axis1 = R.col(1)};
        }
        std::array<SsvAxes, kSsvTurnedAtOnce> together = starts;
        turnToSmallBoxes(sets, together);
        for (std::size_t k = 0; k < sets.size(); ++k)
        {
            SsvAxes alone = starts[k];
            turnToSmallBoxes(std::span(sets).subspan(k, 1), std::span(&alone, 1));
            EXPECT_EQ(alone.axis0, together[k].axis0);
            EXPECT_EQ(alone.axis1, together[k].axis1);
            turned += alone.axis0 != starts[k].axis0 ? 1 : 0;
        }
    }
    EXPECT_GT(turned, 1000);
}

TEST(SsvTree, TakesAtMost130BytesPerTriangleWithItsMesh)
{
    const auto inUse = []
    {
        const struct mallinfo2 heap = mallinfo2();
        return heap.uordblks + heap.hblkhd;
    };
    const TriangleMesh mesh = makeSphere(1.0, 6);
    const SsvTree first = buildSsvTree(mesh);  // threads have what they need from here on
    const std::size_t before = inUse();
    const SsvTree tree = buildSsvTree(mesh);
    const std::size_t after = inUse();
    if (after == 0)
    {
        GTEST_SKIP() << "this allocator does not count";
    }
    ASSERT_GT(after, before + sizeof(SsvNode) * tree.nodes().size());
    EXPECT_LE(after - before, 130 * mesh.triangles.size());
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
    for (int i = 0; i < 60; ++i)
    {
        const TriangleMesh mesh =
            i % 2 == 0 ? makeSphere(1.0, 2) : soup(random, random.integer(1, 200), 1.0, 0.2);
        SsvTree tree = buildSsvTree(mesh);
        const std::vector<SsvNode> before(tree.nodes().begin(), tree.nodes().end());
        const std::vector<Vector3d> vertices = deformed(mesh.vertices, random);
        tree.refit(vertices);
        expectSoundTree(tree, "deformed " + std::to_string(i));
        EXPECT_EQ(tree.mesh().vertices, vertices);
        for (std::size_t k = 0; k < before.size(); ++k)
        {
            EXPECT_EQ(tree.nodes()[k].first, before[k].first);
            EXPECT_EQ(tree.nodes()[k].count, before[k].count);
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

/// Every corner below the node is in its slabs, and touches both ends of each.
void expectExactSlabs(const SsvTree& tree, std::int32_t index)
{
    const SsvNode& node = tree.nodes()[static_cast<std::size_t>(index)];
    const FaceSlabs& faces = tree.faceSlabs();
    for (std::size_t k = 0; k < faces.normals.size(); ++k)
    {
        const Slab slab = faces.ofNode(index)[k];
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        std::vector<std::int32_t> open{index};
        while (!open.empty())
        {
            const SsvNode& next = tree.nodes()[static_cast<std::size_t>(open.back())];
            open.pop_back();
            for (std::int32_t child = 0; child < next.count; ++child)
            {
                open.push_back(next.first + child);
            }
            for (std::size_t c = 0; next.isLeaf() && c < 3; ++c)
            {
                const double height = faces.normals[k].dot(tree.corners(next.first)[c]);
                low = std::min(low, height);
                high = std::max(high, height);
            }
        }
        EXPECT_DOUBLE_EQ(slab.low, low);
        EXPECT_DOUBLE_EQ(slab.high, high);
    }
    for (std::int32_t child = 0; child < node.count; ++child)
    {
        expectExactSlabs(tree, node.first + child);
    }
}

TEST(SsvTree, KnowsItsFlatFacesExactly)
{
    Random random(4);
    TriangleMesh sides = flatPlate(6, 1.0);
    for (const Vector3d& axis : {Vector3d(Vector3d::UnitX()), Vector3d(Vector3d::UnitY())})
    {
        TriangleMesh side = flatPlate(6, 1.0);
        transformMesh(side, Eigen::Affine3d(Eigen::AngleAxisd(1.5707963267948966, axis)));
        appendMesh(sides, side);
    }
    const Eigen::Isometry3d X = random.pose(2.0);
    transformMesh(sides, Eigen::Affine3d(X.matrix()));
    SsvTree tree = buildSsvTree(sides);
    ASSERT_EQ(tree.faceSlabs().normals.size(), 3u);
    for (const Vector3d& normal : tree.faceSlabs().normals)
    {
        EXPECT_NEAR((X.linear().transpose() * normal).cwiseAbs().maxCoeff(), 1.0, 1e-15);
    }
    expectExactSlabs(tree, 0);
    std::vector<Vector3d> moved = sides.vertices;
    for (Vector3d& vertex : moved)
    {
        vertex = 2.0 * vertex + Vector3d(0.0, 3.0, 0.0);
    }
    tree.refit(moved);
    expectExactSlabs(tree, 0);
    EXPECT_TRUE(buildSsvTree(makeSphere(1.0, 4)).faceSlabs().empty());
    EXPECT_TRUE(buildSsvTree(cube(1.0)).faceSlabs().empty());
}
}  // namespace
}  // namespace bullet_ccd::tests
