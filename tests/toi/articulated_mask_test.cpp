/// Self-collision of joined links at the level of triangles, and bodies that rest on each other.
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// A bar of `parts` boxes end to end, so that the mask of a joint ends somewhere.
TriangleMesh bar(double length, double half, int parts)
{
    TriangleMesh mesh;
    const double part = length / parts;
    for (int i = 0; i < parts; ++i)
    {
        mesh = merged({mesh, box({i * part, -half, -half}, {(i + 1) * part, half, half})});
    }
    return mesh;
}

/// Two bars joined at their ends, overlapping there, that fold up.
ArticulatedScene foldingBars(double from, double to)
{
    ArticulatedScene scene;
    scene.tree = planarChain({1.0, 1.0});
    scene.linkMeshes = {{}, bar(1.0, 0.05, 20), bar(1.0, 0.05, 20)};
    scene.motion = {.root = {}, .positions = {0, 0, from}, .rates = {0, 0, to - from}};
    scene.selfPairs = {{1, 2}};
    return scene;
}

/// Poses of link 1 in link 2, over the joint's range from `from` to `to`.
std::vector<Eigen::Isometry3d> jointPoses(const KinematicTree& tree, double from, double to)
{
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i <= 20; ++i)
    {
        poses.push_back(linkInParent(tree.links[2], from + (to - from) * i / 20.0).inverse());
    }
    return poses;
}

TEST(PairMask, JoinedLinksFoldUntilTheirFarEndsMeet)
{
    const ArticulatedScene scene = foldingBars(0.0, std::numbers::pi);
    const BuiltScene built(scene);
    ToiWorkspace work;
    ArticulatedBody body = built.body();
    EXPECT_EQ(articulatedToi(body, Environment(), {}, work).status, ToiStatus::Overlapping);

    // The range up to a right angle marks the region of the joint.
    const PairMask mask = maskNear(built.linkTree(1),
                                   built.linkTree(2),
                                   jointPoses(scene.tree, 0.0, 0.5 * std::numbers::pi),
                                   1e-3);
    ASSERT_FALSE(mask.isEmpty());
    const std::array masks{LinkMask{.link = 1, .otherLink = 2, .mask = &mask}};
    body.masks = masks;
    const ArticulatedToiResult result = articulatedToi(body, Environment(), {}, work);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    // Parallel bars of width 0.1 would lie on each other at pi; off the joint they meet before.
    const double angle = result.time * std::numbers::pi;
    EXPECT_GT(angle, 0.5 * std::numbers::pi);
    EXPECT_LT(angle, std::numbers::pi);
    const LinkContact& contact = result.contacts[0];
    EXPECT_EQ(contact.stopJoint, 2);
    EXPECT_FALSE(mask.exemptsTriangles(contact.triangleLink, contact.triangleOther));
    // No pair that counts was missed before: brute force over unmasked pairs.
    const Eigen::Isometry3d X_21 = linkInParent(scene.tree.links[2], angle).inverse();
    EXPECT_GT((contact.pointLink - contact.pointOther).norm(), 0.0);
    EXPECT_LT(X_21.translation().norm(), 1.1);
}

TEST(PairMask, UnmaskedPairsAreFoundAtTheirTime)
{
    // The far end of link 2 carries a cross bar that meets the far end of link 1: a closed form
    // that the mask must not hide. The tip at distance r = 1 from the joint, and a flag on link 1.
    ArticulatedScene scene = foldingBars(0.0, 3.0);
    scene.linkMeshes[1] = merged({bar(1.0, 0.05, 20), segment({0.2, 0.0, 0.0}, {0.2, 0.5, 0.0})});
    scene.linkMeshes[2] = merged({bar(0.05, 0.05, 1), segment({0, 0, 0}, {1, 0, 0})});
    const BuiltScene built(scene);
    const PairMask mask =
        maskNear(built.linkTree(1), built.linkTree(2), jointPoses(scene.tree, 0.0, 2.5), 0.02);
    const std::array masks{LinkMask{.link = 1, .otherLink = 2, .mask = &mask}};
    ArticulatedBody body = built.body();
    body.masks = masks;
    ToiWorkspace work;
    const ArticulatedToiResult result =
        articulatedToi(body, Environment(), {.toi = {.tolerance = 1e-7}}, work);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    // Link 2 lies along the ray at angle q from (1, 0); the flag stands at x = 0.2 up to y = 0.5:
    // its tip (0.2, 0.5) is at angle pi - atan(0.5 / 0.8) and within reach 1.
    const double angle = std::numbers::pi - std::atan2(0.5, 0.8);
    EXPECT_NEAR(result.time, angle / 3.0, 1e-6);
    EXPECT_LE(result.time, angle / 3.0 + 1e-12);
}

TEST(PairMask, ABodyThatStandsOnTheFloorCanMoveItsArms)
{
    // The base overlaps the floor; the arm above it comes down on it.
    ArticulatedScene scene;
    scene.tree = planarChain({1.0}, {0, 0.5, 0});
    scene.linkMeshes = {box({-0.2, -0.01, -0.2}, {0.2, 0.5, 0.2}),
                        box({0.3, -0.02, -0.02}, {1, 0.02, 0.02})};
    scene.motion = {.root = {.v_W = {0.01, 0, 0}}, .positions = {0, 1.0}, .rates = {0, -2.0}};
    scene.obstacles = {quad({-3, 0, -3}, {-3, 0, 3}, {3, 0, 3}, {3, 0, -3})};
    scene.obstacleMotions = {{}};
    const BuiltScene built(scene);
    const Environment environment(built.obstacles());
    ToiWorkspace work;
    ArticulatedBody body = built.body();
    EXPECT_EQ(articulatedToi(body, environment, {}, work).status, ToiStatus::Overlapping);
    const std::array start{Eigen::Isometry3d::Identity()};
    const PairMask mask = maskNear(built.linkTree(0), *built.obstacles()[0].tree, start, 1e-3);
    const std::array masks{LinkMask{.link = 0, .obstacle = 0, .mask = &mask}};
    body.masks = masks;
    const ArticulatedToiResult result = articulatedToi(body, environment, {}, work);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_EQ(result.contacts[0].link, 1);
    // The lower edge of the tip: (1, -0.02) about (0, 0.5) reaches y = 0.
    const double angle = std::asin(0.5 / std::hypot(1.0, 0.02)) - std::atan2(0.02, 1.0);
    EXPECT_NEAR(result.time, (1.0 + angle) / 2.0, 2e-5);
}

TEST(PairMask, DistancesLeaveOutExemptPairsOnly)
{
    Random random(47);
    int exemptWereNearest = 0;
    int allExempt = 0;
    constexpr int kScenes = 100;
    for (int i = 0; i < kScenes; ++i)
    {
        const TriangleMesh a = soup(random, random.integer(1, 20), 1.0, 0.5);
        const TriangleMesh b = soup(random, random.integer(1, 20), 1.0, 0.5);
        const SsvTree treeA = buildSsvTree(a);
        const SsvTree treeB = buildSsvTree(b);
        const Eigen::Isometry3d X_BA = random.pose(1.0);
        const auto marks = [&](const TriangleMesh& mesh)
        {
            std::vector<std::uint8_t> result;
            const double share = random.uniform(0.3, 1.0);
            for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
            {
                result.push_back(random.uniform(0.0, 1.0) < share ? 1 : 0);
            }
            return result;
        };
        const PairMask mask(treeA, treeB, marks(a), marks(b));
        std::vector<TrianglePair> all;
        trianglePairsWithin(treeA, treeB, X_BA, 1e3, all);
        double nearest = 1e3;
        for (const TrianglePair& pair : all)
        {
            if (!mask.exemptsTriangles(pair.triangleA, pair.triangleB))
            {
                nearest = std::min(nearest, pair.distance);
            }
        }
        const TrianglePair found = treeDistance(treeA, treeB, X_BA, 1e3, mask.nodeMarks());
        ASSERT_EQ(found.distance, nearest) << i;
        ASSERT_EQ(found.triangleA == kNone, nearest == 1e3) << i;
        allExempt += found.triangleA == kNone ? 1 : 0;
        exemptWereNearest += treeDistance(treeA, treeB, X_BA, 1e3).distance < nearest ? 1 : 0;
    }
    EXPECT_GT(exemptWereNearest, kScenes / 10);
    EXPECT_LT(allExempt, kScenes / 3);
}

/// Nodes below which all is exempt intersect: they would be opened down to all pairs of triangles.
TEST(PairMask, CostsNothingWhereAllBelowTwoNodesIsExempt)
{
    Random random(92);
    const TriangleMesh mesh = soup(random, 600, 1.0, 0.5);
    const SsvTree tree = buildSsvTree(mesh);
    const std::vector<std::uint8_t> all(mesh.triangles.size(), 1);
    const PairMask mask(tree, tree, all, all);
    RigidMotion turns;
    turns.w_W = {0.0, 0.0, 1.0};
    const std::array<MovingBody, 2> bodies{MovingBody{.tree = &tree, .motion = turns},
                                           MovingBody{.tree = &tree, .motion = RigidMotion{}}};
    const std::array<BodyPair, 1> pairs{{{.bodyA = 0, .bodyB = 1, .mask = &mask}}};
    ToiWorkspace work;
    for (const ToiStrategy strategy : {ToiStrategy::BestFirst, ToiStrategy::Interval})
    {
        const FirstContactResult result =
            firstContact(bodies, pairs, {.tolerance = 1e-5, .strategy = strategy}, work);
        EXPECT_EQ(result.status, ToiStatus::Separated);
        EXPECT_LE(result.counters.nodePairs + result.counters.trianglePairs, 16);
    }
}

TEST(PairMask, RefusesMarksOfAnotherMesh)
{
    const SsvTree tree = buildSsvTree(cube(1.0));
    const std::vector<std::uint8_t> few(3, 1);
    const std::vector<std::uint8_t> right(tree.mesh().triangles.size(), 1);
    EXPECT_THROW((void)PairMask(tree, tree, few, right), std::invalid_argument);
    EXPECT_THROW((void)PairMask(tree, tree, right, few), std::invalid_argument);
    EXPECT_FALSE(PairMask(tree, tree, right, right).isEmpty());
}

TEST(SelfPairsOf, LeavesOutLinksWithoutAJointBetweenAndDisabledPairs)
{
    KinematicTree tree = planarChain({1.0, 1.0, 1.0});
    tree.links[2].joint.type = JointType::Fixed;
    const SsvTree mesh = buildSsvTree(cube(0.1));
    const std::vector<const SsvTree*> meshes{&mesh, &mesh, &mesh, &mesh};
    using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;
    EXPECT_EQ(selfPairsOf(tree, meshes), (Pairs{{0, 1}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}));
    const Pairs disabled{{3, 2}, {0, 1}};
    EXPECT_EQ(selfPairsOf(tree, meshes, disabled), (Pairs{{0, 2}, {0, 3}, {1, 3}}));
    const std::vector<const SsvTree*> some{nullptr, &mesh, nullptr, &mesh};
    EXPECT_EQ(selfPairsOf(tree, some), (Pairs{{1, 3}}));
}
}  // namespace
}  // namespace bullet_ccd::tests
