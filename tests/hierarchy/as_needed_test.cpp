// Hierarchies that are built as far as they are looked at.
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tree_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <random>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A sphere of 20,480 triangles.
TriangleMesh sphere()
{
    return makeSphere(1.0, 5);
}

/// Most of its triangles are in a ten-thousandth of its size, and others all at one place.
TriangleMesh crowded()
{
    TriangleMesh mesh = makeSphere(1.0, 2);
    TriangleMesh small = sphere();
    transformMesh(small, Eigen::Affine3d(Eigen::Translation3d(1, 2, 3) * Eigen::Scaling(1e-4)));
    appendMesh(mesh, small);
    TriangleMesh same = makeTriangle({2, 0, 0}, {2, 1, 0}, {2, 0, 1});
    same.triangles.assign(5000, same.triangles[0]);
    appendMesh(mesh, same);
    return mesh;
}

/// A plate of 20,000 triangles in a plane that is parallel to no axis.
TriangleMesh plate()
{
    TriangleMesh mesh;
    constexpr std::int32_t kSide = 100;
    for (std::int32_t i = 0; i <= kSide; ++i)
    {
        for (std::int32_t k = 0; k <= kSide; ++k)
        {
            mesh.vertices.emplace_back(0.01 * i, 0.01 * k, 0.0);
            const std::int32_t at = i * (kSide + 1) + k;
            if (i < kSide && k < kSide)
            {
                mesh.triangles.push_back({at, at + kSide + 1, at + 1});
                mesh.triangles.push_back({at + 1, at + kSide + 1, at + kSide + 2});
            }
        }
    }
    const Vector3d axis = Vector3d(1, 2, 3).normalized();
    transformMesh(mesh, Eigen::Affine3d(Eigen::AngleAxisd(0.7, axis)));
    return mesh;
}

std::vector<TriangleMesh> meshes()
{
    return {sphere(), crowded(), plate(), makeTorus(1.0, 0.3, 120, 60)};
}

/// Opens all doors in a random order.
void openAtRandom(const SsvTree& tree, unsigned seed)
{
    std::mt19937 engine(seed);
    std::vector<std::int32_t> open{0};
    while (!open.empty())
    {
        std::swap(open.back(), open[engine() % open.size()]);
        const SsvNode& node = tree.nodes()[static_cast<std::size_t>(open.back())];
        open.pop_back();
        tree.open(node);
        for (std::int32_t k = 0; k < node.count; ++k)
        {
            open.push_back(node.first + k);
        }
    }
}

/// Nodes that are not in use are the same, too, once all are open.
void expectSameBits(const SsvTree& a, const SsvTree& b)
{
    a.openAll();
    b.openAll();
    ASSERT_EQ(a.nodes().size(), b.nodes().size());
    EXPECT_EQ(std::memcmp(a.nodes().data(), b.nodes().data(), a.nodes().size_bytes()), 0);
    EXPECT_EQ(a.radius(), b.radius());
    for (std::size_t slot = 0; slot < a.mesh().triangles.size(); ++slot)
    {
        ASSERT_EQ(a.triangle(static_cast<std::int32_t>(slot)),
                  b.triangle(static_cast<std::int32_t>(slot)));
        ASSERT_EQ(a.corners(static_cast<std::int32_t>(slot)),
                  b.corners(static_cast<std::int32_t>(slot)));
    }
    ASSERT_EQ(a.faceSlabs().normals, b.faceSlabs().normals);
}

TEST(AsNeeded, NothingBelowTheDoorsIsBuiltAtFirst)
{
    for (const TriangleMesh& mesh : meshes())
    {
        const SsvTree tree = buildSsvTreeAsNeeded(mesh);
        EXPECT_EQ(tree.builtTriangles(), 0u);
        tree.openAll();
        EXPECT_EQ(tree.builtTriangles(), mesh.triangles.size());
    }
    EXPECT_EQ(buildSsvTreeAsNeeded(makeSphere(1.0, 3)).builtTriangles(), 1280u);
    EXPECT_THROW((void)buildSsvTreeAsNeeded({}), std::invalid_argument);
    TriangleMesh broken = sphere();
    broken.triangles[7000][2] = -1;
    EXPECT_THROW((void)buildSsvTreeAsNeeded(broken), std::invalid_argument);
}

TEST(AsNeeded, EveryVolumeContainsTheTrianglesBelowIt)
{
    for (const TriangleMesh& mesh : meshes())
    {
        const SsvTree tree = buildSsvTreeAsNeeded(mesh);
        openAtRandom(tree, 3);
        const TreeCheck check = checkTree(tree);
        EXPECT_LE(check.worstEscape, 0.0);
        EXPECT_LE(check.worstCoreRadius, 0.0);
        EXPECT_GT(check.doors, 1u);
        EXPECT_EQ(std::ranges::count(check.leavesOfTriangle, 1),
                  static_cast<std::ptrdiff_t>(mesh.triangles.size()));
        EXPECT_LT(check.depth, 40);
    }
}

TEST(AsNeeded, SlabsContainTheTrianglesBelow)
{
    const SsvTree tree = buildSsvTreeAsNeeded(plate());
    ASSERT_FALSE(tree.faceSlabs().empty());
    const Vector3d normal = tree.faceSlabs().normals[0];
    constexpr double kRounding = 1e-13;  // volumes in single precision blur by 1e-7
    const auto expectFlat = [&](std::int32_t node)
    {
        const Slab slab = tree.faceSlabs().ofNode(node)[0];
        EXPECT_LE(slab.high - slab.low, kRounding);
        const double height = normal.dot(tree.cornersOfTriangle(0)[0]);
        EXPECT_NEAR(slab.low, height, kRounding);
    };
    expectFlat(0);  // before anything is built
    tree.openAll();
    for (std::size_t i = 0; i < tree.nodes().size(); ++i)
    {
        if (tree.nodes()[i].first != kNone)
        {
            expectFlat(static_cast<std::int32_t>(i));
        }
    }
}

TEST(AsNeeded, IsTheSameForAnyOrderAndNumberOfThreads)
{
    for (const TriangleMesh& mesh : meshes())
    {
        const auto build = [&](std::size_t threads, unsigned seed)
        {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            SsvTree tree = buildSsvTreeAsNeeded(mesh);
            openAtRandom(tree, seed);
            return tree;
        };
        const SsvTree first = build(1, 1);
        for (const unsigned threads : {2U, 3U, 8U})
        {
            expectSameBits(first, build(threads, threads));
        }
        TriangleMesh turned = mesh;  // how a file lists the triangles changes only their numbers
        std::ranges::reverse(turned.triangles);
        const SsvTree second = buildSsvTreeAsNeeded(turned);
        second.openAll();
        EXPECT_EQ(
            std::memcmp(first.nodes().data(), second.nodes().data(), first.nodes().size_bytes()),
            0);
    }
}

TEST(AsNeeded, ThreadsThatAskAtTheSameTimeGetTheAnswersOfAWholeTree)
{
    Random random(5);
    const TriangleMesh mesh = makeTorus(1.0, 0.3, 160, 80);
    const SsvTree whole = buildSsvTree(mesh);
    constexpr std::size_t kQueries = 64;
    std::vector<Eigen::Isometry3d> poses;
    std::vector<double> expected;
    for (std::size_t i = 0; i < kQueries; ++i)
    {
        poses.push_back(random.pose(2.5));
        expected.push_back(treeDistance(whole, whole, poses.back(), kInfinity).distance);
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
    for (int repetition = 0; repetition < 10; ++repetition)
    {
        const SsvTree tree = buildSsvTreeAsNeeded(mesh);
        std::vector<double> found(kQueries);
        tbb::parallel_for(std::size_t{0},
                          kQueries,
                          [&](std::size_t i)
                          { found[i] = treeDistance(tree, tree, poses[i], kInfinity).distance; });
        for (std::size_t i = 0; i < kQueries; ++i)
        {
            EXPECT_NEAR(found[i], expected[i], 2e-6 * expected[i]);
        }
    }
}

TEST(AsNeeded, AnswersAreThoseOfAWholeTree)
{
    Random random(7);
    ToiWorkspace work;
    constexpr double kTolerance = 1e-6;
    int hits = 0;
    for (const TriangleMesh& mesh : {sphere(), plate(), makeTorus(1.0, 0.3, 120, 60)})
    {
        const SsvTree whole = buildSsvTree(mesh);
        const SsvTree tree = buildSsvTreeAsNeeded(mesh);
        for (int i = 0; i < 20; ++i)
        {
            RigidMotion motion;
            const Vector3d from = random.direction();
            motion.X_W0.linear() = random.rotation();
            motion.X_W0.translation() = 5.0 * from;
            motion.v_W = -5.0 * from;
            motion.w_W = 2.0 * random.direction();
            const auto distance = [&](const SsvTree& one, double t)
            { return treeDistance(one, one, motion.at(t).X_W, kInfinity).distance; };
            EXPECT_NEAR(distance(tree, 0.2), distance(whole, 0.2), 2e-6 * distance(whole, 0.2));
            const auto toi = [&](const SsvTree& one)
            {
                return rigidToi({.tree = &one, .motion = motion},
                                {.tree = &one},
                                {.tolerance = kTolerance},
                                work);
            };
            const ToiResult expected = toi(whole);
            const ToiResult found = toi(tree);
            ASSERT_EQ(found.status, expected.status);
            if (found.status == ToiStatus::Hit)
            {
                ++hits;
                EXPECT_GT(found.gap, 0.0);
                EXPECT_LE(found.gap, kTolerance);
                EXPECT_LE(distance(whole, found.time), kTolerance);
                EXPECT_GT(distance(whole, found.time), 0.0);
            }
        }
    }
    EXPECT_GT(hits, 20);
}

TEST(AsNeeded, AQueryBuildsWhatItLooksAt)
{
    const SsvTree large = buildSsvTreeAsNeeded(makeSphere(1.0, 7));
    const SsvTree small = buildSsvTree(makeSphere(0.1, 2));
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        const SsvTree tree = buildSsvTreeAsNeeded(large.mesh());
        RigidBody moving{.tree = &small};
        moving.motion.X_W0.translation() = Vector3d(2.0, 0.3, 0.1);
        moving.motion.v_W = Vector3d(-2.0, 0.0, 0.0);
        ToiWorkspace work;
        const ToiResult hit =
            rigidToi(moving, {.tree = &tree}, {.tolerance = 1e-3, .strategy = strategy}, work);
        ASSERT_EQ(hit.status, ToiStatus::Hit);
        EXPECT_GT(tree.builtTriangles(), 0u);
        EXPECT_LT(tree.builtTriangles(), tree.mesh().triangles.size() / 20);
    }
}

TEST(AsNeeded, CopiesAndFilesAreWhole)
{
    const TriangleMesh mesh = makeTorus(1.0, 0.3, 120, 60);
    const SsvTree tree = buildSsvTreeAsNeeded(mesh);
    SsvTree copy = tree;
    EXPECT_EQ(tree.builtTriangles(), mesh.triangles.size());
    std::vector<Vector3d> moved = mesh.vertices;
    for (Vector3d& vertex : moved)
    {
        vertex = vertex.cwiseProduct(Vector3d(1.0, 2.0, 0.5)) + Vector3d(3, 4, 5);
    }
    copy.refit(moved);
    SsvTree refitted = buildSsvTreeAsNeeded(mesh);
    refitted.refit(moved);
    expectSameBits(copy, refitted);
    EXPECT_LE(checkTree(copy).worstEscape, 0.0);
    const TempFolder folder;
    const std::filesystem::path file = folder.path() / "torus.ssv";
    saveSsvTree(buildSsvTreeAsNeeded(mesh), file);
    const SsvTree saved = loadSsvTree(mesh, file);
    expectSoundTree(saved, "saved");
    EXPECT_LE(saved.nodes().size(), 2 * mesh.triangles.size() - 1);
    const SsvTree source = buildSsvTreeAsNeeded(mesh);
    SsvTree taken = std::move(copy);
    taken = source;
    EXPECT_EQ(source.builtTriangles(), mesh.triangles.size());
    expectSameBits(taken, tree);
}
}  // namespace
}  // namespace bullet_ccd::tests
