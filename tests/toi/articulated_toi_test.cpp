/// articulatedToi against brute force on random trees among moving and resting obstacles.
#include "benchmarks/reference/oracles/articulated_judge.h"
#include "benchmarks/reference/queries/soak_tally.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
ArticulatedScene randomScene(Random& random)
{
    ArticulatedScene scene;
    const int links = random.integer(3, 6);
    scene.tree = randomTree(random, links, 0.3);
    scene.motion = randomJointMotion(random, scene.tree, random.uniform(1.0, 5.0));
    for (int i = 0; i < links; ++i)
    {
        scene.linkMeshes.push_back(random.chance(0.15) ? TriangleMesh{}
                                                       : scaled(randomMesh(random), 0.3));
        for (int k = 0; k + 1 < i; ++k)
        {
            if (random.chance(0.6) &&
                !scene.linkMeshes[static_cast<std::size_t>(i)].vertices.empty() &&
                !scene.linkMeshes[static_cast<std::size_t>(k)].vertices.empty())
            {
                scene.selfPairs.emplace_back(k, i);
            }
        }
    }
    for (int i = random.integer(4, 8); i > 0; --i)
    {
        scene.obstacles.push_back(scaled(randomMesh(random), 0.5));
        RigidMotion motion = randomRigidMotion(random, random.chance(0.5) ? 1.5 : 0.0);
        motion.X_W0.translation() =
            scene.motion.root.X_W0.translation() + random.uniform(1.0, 2.5) * random.direction();
        scene.obstacleMotions.push_back(motion);
    }
    return scene;
}

ArticulatedToiResult expectRight(const ArticulatedScene& scene, double tolerance, SoakTally& tally)
{
    const ArticulatedToiResult result = query(scene, tolerance);
    const Judgement judgement = judgeArticulated(scene, {.tolerance = tolerance}, result);
    EXPECT_EQ(judgement.verdict, Verdict::Right) << judgement.text();
    tally.add(result.status, judgement.verdict);
    return result;
}

TEST(ArticulatedToi, AgreesWithBruteForceOnRandomTrees)
{
    Random random(90);
    SoakTally tally;
    std::ptrdiff_t selfHits = 0;
    const int kScenes = longTests() ? 250 : 120;
    for (int i = 0; i < kScenes; ++i)
    {
        SCOPED_TRACE(i);
        const ArticulatedScene scene = randomScene(random);
        const ArticulatedToiResult result =
            expectRight(scene, random.logUniform(1e-7, 1e-3), tally);
        selfHits += std::count_if(result.contacts.begin(),
                                  result.contacts.end(),
                                  [](const LinkContact& c) { return c.otherLink != kNone; });
    }
    EXPECT_GT(tally.hits, kScenes / 4);
    EXPECT_LT(tally.hits + tally.overlapping, kScenes * 9 / 10);
    EXPECT_GT(selfHits, kScenes / 60);
}

TEST(ArticulatedToi, AgreesWithBruteForceOnRandomFingers)
{
    // Planar chains that close around a resting obstacle: many links near it at the same time.
    Random random(91);
    SoakTally tally;
    constexpr int kScenes = 200;
    for (int i = 0; i < kScenes; ++i)
    {
        SCOPED_TRACE(i);
        ArticulatedScene scene;
        const std::vector<double> lengths(static_cast<std::size_t>(random.integer(1, 4)),
                                          random.uniform(0.3, 0.7));
        scene.tree = planarChain(lengths);
        scene.linkMeshes.resize(1);
        scene.motion.positions = {0.0};
        scene.motion.rates = {0.0};
        for (const double length : lengths)
        {
            scene.linkMeshes.push_back(box({0.05, -0.03, -0.03}, {length - 0.05, 0.03, 0.03}));
            scene.motion.positions.push_back(random.uniform(-0.3, 0.3));
            scene.motion.rates.push_back(random.uniform(-0.3, 1.8));
        }
        scene.obstacles = {randomMesh(random)};
        scene.obstacleMotions = {
            restAt(poseOf({random.uniform(0.2, 1.2), random.uniform(0.8, 1.8), 0.0}))};
        for (std::int32_t a = 1; a < static_cast<std::int32_t>(scene.tree.size()); ++a)
        {
            for (std::int32_t b = a + 2; b < static_cast<std::int32_t>(scene.tree.size()); ++b)
            {
                scene.selfPairs.emplace_back(a, b);
            }
        }
        expectRight(scene, 1e-6, tally);
    }
    EXPECT_GT(tally.hits, kScenes / 5);
    EXPECT_LT(tally.hits + tally.overlapping, kScenes * 9 / 10);
}

TEST(ArticulatedToi, OneLinkMovesLikeARigidBody)
{
    Random random(92);
    int hits = 0;
    for (int i = 0; i < 200; ++i)
    {
        const RigidScene rigid = randomRigidScene(random);
        ArticulatedScene scene;
        scene.tree.links.resize(1);
        scene.motion = {.root = rigid.motionA, .positions = {0.0}, .rates = {0.0}};
        scene.linkMeshes = {rigid.meshA};
        scene.obstacles = {rigid.meshB};
        scene.obstacleMotions = {rigid.motionB};
        const ToiResult expected = queryToi(rigid, 1e-6);
        const ArticulatedToiResult result = query(scene, 1e-6);
        ASSERT_EQ(result.status, expected.status) << i;
        EXPECT_NEAR(result.time, expected.time, 1e-5) << i;
        hits += result.status == ToiStatus::Hit ? 1 : 0;
    }
    EXPECT_GT(hits, 60);
}

TEST(ArticulatedToi, TouchingPairsThatDoNotMoveAreSkipped)
{
    // The first link rests on the obstacle, the second turns away from it.
    ArticulatedScene scene;
    scene.tree = planarChain({1.0, 1.0});
    scene.linkMeshes = {{}, segment({0, 0, 0}, {1, 0, 0}), segment({0.1, 0, 0}, {1, 0, 0})};
    scene.obstacles = {box({0.2, -1, -1}, {0.8, 0, 1})};
    scene.obstacleMotions = {{}};
    scene.motion = {.root = {}, .positions = {0, 0, 0}, .rates = {0, 0, 1.5}};
    EXPECT_EQ(query(scene, 1e-6).status, ToiStatus::Separated);
    scene.motion.rates = {0, 0.5, 0};
    EXPECT_EQ(query(scene, 1e-6).status, ToiStatus::Overlapping);
}

TEST(ArticulatedToi, CommonMotionOfTheTreeDoesNotMatterForItsSelfPairs)
{
    // G04 on a base that turns many times.
    ArticulatedScene scene;
    scene.tree = planarChain({1.5, 1.0, 1.0});
    scene.linkMeshes = {{},
                        segment({0, 0, 0}, {1.5, 0, 0}),
                        segment({0, 0, 0}, {1, 0, 0}),
                        segment({0, 0, 0}, {1, 0, 0})};
    scene.selfPairs = {{1, 3}};
    scene.motion = {.root = {.v_W = {100, 50, 0}, .w_W = {30, -40, 200}},
                    .positions = {0, 0, 0, 0},
                    .rates = {0, 0, 2.5, 2.5}};
    const ArticulatedToiResult result = query(scene, 1e-6);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_NEAR(result.time, std::acos(-0.5) / 2.5, 1e-6);
    EXPECT_LT(result.counters.states, 200);
}

TEST(ArticulatedToi, RejectsSizesThatDoNotMatchAndMotionsThatAreNotFinite)
{
    Random random(93);
    const ArticulatedScene good = randomScene(random);
    ArticulatedScene scene = good;
    scene.linkMeshes.pop_back();
    EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
    scene = good;
    scene.motion.rates.pop_back();
    EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
    scene = good;
    scene.motion.positions.push_back(0.0);
    EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    {
        scene = good;
        scene.motion.rates.back() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motion.positions.back() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motion.root.v_W.x() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.obstacleMotions[0].w_W.z() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
