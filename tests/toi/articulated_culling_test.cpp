/// Every stage of articulatedToi switched off in turn: the same answer, and the counters that say
/// what it saved.
#include "bullet_ccd/toi/articulated/articulated_culling.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/tree_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// A chain of that many joints, some spherical, among small obstacles of which a few move.
ArticulatedScene randomChain(Random& random, int joints, double fastest)
{
    ArticulatedScene scene;
    scene.tree = randomBallTree(random, joints + 1, 0.1);
    scene.motion = randomJointMotion(random, scene.tree, fastest);
    for (int i = 0; i <= joints; ++i)
    {
        scene.linkMeshes.push_back(random.chance(0.1)
                                       ? TriangleMesh{}
                                       : scaled(soup(random, random.integer(1, 4), 0.5, 0.7), 0.5));
        for (int k = 0; k + 1 < i; ++k)
        {
            const auto has = [&](int link)
            { return !scene.linkMeshes[static_cast<std::size_t>(link)].triangles.empty(); };
            if (random.chance(0.3) && has(i) && has(k))
            {
                scene.selfPairs.emplace_back(k, i);
            }
        }
    }
    for (int i = random.integer(2, 5); i > 0; --i)
    {
        scene.obstacles.push_back(scaled(soup(random, random.integer(1, 4), 0.7, 0.8), 1.0));
        RigidMotion motion = randomRigidMotion(random, random.chance(0.3) ? 1.5 : 0.0);
        motion.X_W0.translation() =
            scene.motion.root.X_W0.translation() + random.uniform(0.9, 2.2) * random.direction();
        scene.obstacleMotions.push_back(motion);
    }
    return scene;
}

/// The gap of the earliest contact lies within the tolerance, so that answers can differ by the
/// time that takes, which brute force knows: it is asked where the earlier answer ends.
TEST(ArticulatedToi, StagesSwitchedOffGiveTheSameAnswer)
{
    Random random(2502);
    const std::array<ArticulatedToiOptions, 6> stages{
        {{},
         {.toi = {}, .cullBySpace = false},
         {.toi = {}, .cullByTime = false},
         {.toi = {}, .subdivide = false},
         {.toi = {.strategy = ToiStrategy::Interval}},
         {.toi = {}, .cullBySpace = false, .cullByTime = false, .subdivide = false}}};
    std::array<int, 6> hits{};
    int subdivided = 0;
    for (int i = 0; i < 400; ++i)
    {
        const ArticulatedScene scene =
            randomChain(random, random.integer(2, 8), random.logUniform(0.5, 6.0));
        const BuiltScene built(scene);
        const Environment environment(built.obstacles());
        ToiWorkspace work;
        std::array<ArticulatedToiResult, 6> results;
        for (std::size_t k = 0; k < stages.size(); ++k)
        {
            ArticulatedToiOptions options = stages[k];
            options.toi.tolerance = 1e-8;
            results[k] = articulatedToi(built.body(), environment, options, work);
            hits[k] += results[k].status == ToiStatus::Hit ? 1 : 0;
        }
        for (std::size_t k = 1; k < stages.size(); ++k)
        {
            ASSERT_EQ(results[k].status, results[0].status) << i << " stage " << k;
            // A graze within the tolerance may be met early; 1e-8 is reached in 1e-4 then.
            EXPECT_NEAR(results[k].time, results[0].time, 1e-4) << i << " stage " << k;
        }
        const ArticulatedCounters& c = results[0].counters;
        subdivided += c.subdivisions > 0 ? 1 : 0;
        EXPECT_GE(c.culledBySpace, 0);
        EXPECT_GE(c.culledByTime, 0);
        EXPECT_LE(c.culledBySpace + c.culledByTime, c.pairs);
        EXPECT_EQ(results[1].counters.pairs, c.pairs);
        EXPECT_EQ(results[1].counters.culledBySpace, 0);
    }
    EXPECT_GT(hits[0], 100);
    EXPECT_GT(subdivided, 100);
}

/// Any contact will do: the same answer to whether there is one, and the named pair is in contact
/// at the time that is given, which is mostly not the first.
TEST(ArticulatedToi, AnyContactIsOneAndSaysWhetherThereIsAny)
{
    Random random(2503);
    int hits = 0;
    int later = 0;
    int separated = 0;
    std::int64_t trianglesOfAny = 0;
    std::int64_t trianglesOfFirst = 0;
    for (int i = 0; i < 600; ++i)
    {
        const ArticulatedScene scene =
            randomChain(random, random.integer(2, 8), random.logUniform(0.5, 6.0));
        const BuiltScene built(scene);
        const Environment environment(built.obstacles());
        ToiWorkspace work;
        ToiOptions toi{.tolerance = 1e-6, .aim = 0.5, .strategy = ToiStrategy::Interval};
        toi.minimumSeparation = random.chance(0.3) ? 0.01 : 0.0;
        const ArticulatedToiResult first =
            articulatedToi(built.body(), environment, {.toi = toi}, work);
        const ArticulatedToiResult any =
            articulatedToi(built.body(), environment, {.toi = toi, .anyContact = true}, work);
        ASSERT_EQ(isContact(any.status), isContact(first.status)) << i;
        trianglesOfAny += any.counters.trianglePairs;
        trianglesOfFirst += first.counters.trianglePairs;
        if (!isContact(any.status))
        {
            EXPECT_EQ(any.status, first.status) << i;
            ++separated;
            continue;
        }
        ++hits;
        later += any.time > first.time + 1e-3 ? 1 : 0;
        EXPECT_GE(any.time, first.time - 1e-4) << i;
        ASSERT_EQ(any.contacts.size(), 1U) << i;
        const LinkContact& contact = any.contacts[0];
        EXPECT_EQ(contact.time, any.time) << i;
        const ArticulatedBody& body = built.body();
        const auto poseOfLink = [&](std::int32_t link)
        { return linkStateAt(*body.tree, *body.motion, kNone, link, any.time).X_W; };
        const bool isSelf = contact.otherLink != kNone;
        const RigidBody* obstacle =
            isSelf ? nullptr : &built.obstacles()[static_cast<std::size_t>(contact.obstacle)];
        const Eigen::Isometry3d X_WB =
            isSelf ? poseOfLink(contact.otherLink) : obstacle->motion.at(any.time).X_W;
        const SsvTree& treeB =
            isSelf ? *body.linkTrees[static_cast<std::size_t>(contact.otherLink)] : *obstacle->tree;
        EXPECT_LE(treeDistance(*body.linkTrees[static_cast<std::size_t>(contact.link)],
                               treeB,
                               X_WB.inverse() * poseOfLink(contact.link),
                               1.0)
                      .distance,
                  toi.minimumSeparation + toi.tolerance * (1.0 + 1e-6))
            << i;
    }
    EXPECT_GT(hits, 150);
    EXPECT_GT(later, 100);
    EXPECT_GT(separated, 100);
    EXPECT_LT(trianglesOfAny, trianglesOfFirst / 2);
}

TEST(ArticulatedToi, AThousandObstaclesOutOfReachCostNothing)
{
    // A finger on a field of cubes: one is in reach.
    ArticulatedScene scene;
    scene.tree = planarChain({1.0, 1.0});
    scene.linkMeshes = {
        {}, box({0, -0.05, -0.05}, {1, 0.05, 0.05}), box({0, -0.05, -0.05}, {1, 0.05, 0.05})};
    scene.motion = {.root = {}, .positions = {0, 0, 0}, .rates = {0, 0.5, 0.5}};
    for (int i = 0; i < 1000; ++i)
    {
        scene.obstacles.push_back(cube(0.1));
        scene.obstacleMotions.push_back(
            restAt(poseOf({3.0 + i % 32, static_cast<double>(i / 32), 0.0})));
    }
    scene.obstacles.push_back(cube(0.1));
    scene.obstacleMotions.push_back(restAt(poseOf({1.6, 1.0, 0.0})));
    const ArticulatedToiResult result = query(scene, {.toi = {.tolerance = 1e-6}});
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_EQ(result.contacts[0].obstacle, 1000);
    EXPECT_EQ(result.contacts[0].link, 2);
    EXPECT_EQ(result.contacts[0].stopJoint, 2);
    EXPECT_EQ(result.counters.pairs, 2002);
    EXPECT_GE(result.counters.culledBySpace, 1998);
    EXPECT_LT(result.counters.nodePairs, 2000);
}

TEST(ArticulatedToi, NothingIsLookedAtBeyondTheAnswer)
{
    // G05 on a larger scale: twenty pendulums, each with a wall of its own. The first to arrive
    // decides; the others keep their certificate and their triangles are not looked at.
    ArticulatedScene scene;
    scene.tree.links.resize(1);
    scene.linkMeshes.resize(1);
    scene.motion = {.root = {}, .positions = {0.0}, .rates = {0.0}};
    for (int k = 0; k < 20; ++k)
    {
        const double z = 3.0 * k;
        scene.tree.links.push_back(planarChain({1.0}, {0, 0, z}).links[1]);
        scene.linkMeshes.push_back(box({0, -0.01, -0.01}, {1, 0, 0.01}));
        scene.motion.positions.push_back(0.0);
        scene.motion.rates.push_back(k == 13 ? 1.2 : 0.6 + 0.01 * k);
        scene.obstacles.push_back(quad({-2, 0.5, -1}, {-2, 0.5, 1}, {2, 0.5, 1}, {2, 0.5, -1}));
        scene.obstacleMotions.push_back(restAt(poseOf({0, 0, z})));
    }
    const ArticulatedToiResult result = query(scene, {.toi = {.tolerance = 1e-7}});
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_NEAR(result.time, std::asin(0.5) / 1.2, 1e-6);
    ASSERT_EQ(result.contacts.size(), 1U);
    EXPECT_EQ(result.contacts[0].link, 14);
    EXPECT_EQ(result.counters.pairs, 400);
    EXPECT_EQ(result.counters.culledBySpace, 380);
    EXPECT_EQ(result.counters.culledByTime, 19);
}

TEST(ArticulatedToi, SubIntervalsSharpenTheBoxesOfLongMotions)
{
    // Two turns of a long arm past obstacles that only the box of the whole motion meets.
    ArticulatedScene scene;
    scene.tree = planarChain({1.0});
    scene.linkMeshes = {{}, box({0, -0.02, -0.02}, {1, 0.02, 0.02})};
    scene.motion = {.root = {}, .positions = {0, 0.0}, .rates = {0, 12.5}};
    for (int k = 0; k < 4; ++k)
    {
        scene.obstacles.push_back(cube(0.1));
        const double angle = 0.7854 + 1.5708 * k;
        scene.obstacleMotions.push_back(
            restAt(poseOf({1.2 * std::cos(angle), 1.2 * std::sin(angle), 0.0})));
    }
    const ArticulatedToiResult result = query(scene, {.toi = {.tolerance = 1e-6}});
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_GE(result.counters.subdivisions, 3);
}

TEST(Environment, BoxesContainTheirMovingObjects)
{
    Random random(2503);
    for (int i = 0; i < 300; ++i)
    {
        const SsvTree tree = buildSsvTree(randomMesh(random));
        RigidMotion motion = randomRigidMotion(random, random.logUniform(0.1, 300.0));
        motion.reference_B =
            random.chance(0.5) ? Eigen::Vector3d::Zero().eval() : random.inBox(1.0);
        const double begin = random.uniform(0.0, 0.8);
        const double end = begin + random.uniform(0.01, 0.2);
        const Eigen::AlignedBox3d box = boundsOver({&tree, motion}, begin, end);
        for (int k = 0; k < 100; ++k)
        {
            const Eigen::Isometry3d X = oraclePose(motion, random.uniform(begin, end));
            for (const Eigen::Vector3d& vertex : tree.mesh().vertices)
            {
                ASSERT_TRUE(box.contains(X * vertex)) << i;
            }
        }
    }
}

TEST(Environment, IsReusedByManyQueriesWithOneWorkspace)
{
    Random random(2504);
    const ArticulatedScene scene = randomChain(random, 5, 2.0);
    const BuiltScene built(scene);
    const Environment environment(built.obstacles());
    ToiWorkspace work;
    int hits = 0;
    for (int i = 0; i < 100; ++i)
    {
        ArticulatedScene other = scene;
        other.motion = randomJointMotion(random, scene.tree, 2.0);
        ArticulatedBody body = built.body();
        body.motion = &other.motion;
        const ArticulatedToiResult warm = articulatedToi(body, environment, {}, work);
        ToiWorkspace fresh;
        const ArticulatedToiResult cold = articulatedToi(body, environment, {}, fresh);
        ASSERT_EQ(warm.status, cold.status);
        EXPECT_EQ(warm.time, cold.time);
        EXPECT_EQ(warm.counters.nodePairs, cold.counters.nodePairs);
        hits += warm.status == ToiStatus::Hit ? 1 : 0;
    }
    EXPECT_GT(hits, 5);
}
}  // namespace
}  // namespace bullet_ccd::tests
