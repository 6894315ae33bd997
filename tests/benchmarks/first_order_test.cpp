// The bounds of first order that the articulated benchmark compares with: they hold, and queries by
// them find the same contacts.
#include "benchmarks/articulated/first_order.h"

#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Vector3d;
using namespace reference;

TEST(FirstOrder, DirectionalSpeedHoldsOverTheTimeAheadAndIsNotAboveTheSum)
{
    Random random(2308);
    double tightest = 0.0;
    for (int i = 0; i < 4000; ++i)
    {
        const KinematicTree tree = randomBallTree(random, random.integer(2, 9), 0.2);
        MovingFrames frames;
        frames.reset(tree, randomJointMotion(random, tree, random.uniform(0.1, 5.0)));
        const auto frame = static_cast<std::int32_t>(frames.frames().size()) - 1;
        const double t = random.uniform(0.0, 0.9);
        const double ahead = random.logUniform(1e-3, 0.1);
        const double radius = random.uniform(0.0, 1.0);
        const Vector3d n = random.direction();
        const double bound = directionalSpeed(frames, frame, n, t, ahead, radius);
        const SpeedBound sum = frames.speedBound(0, frame);
        EXPECT_LE(bound, (sum.constant + sum.perRadius * radius) * (1.0 + 1e-6) + 1e-9);
        for (int k = 0; k < 20; ++k)
        {
            const MotionState& state = frames.stateAt(0, frame, t + random.uniform(0.0, ahead));
            const Vector3d arm = radius * random.direction();
            const double speed = n.dot(state.v_W + state.w_W.cross(arm));
            EXPECT_LE(speed, bound + 1e-9) << i;
            tightest = std::max(tightest, bound > 0.1 ? speed / bound : 0.0);
        }
    }
    EXPECT_GT(tightest, 0.9);
}

/// A chain of small soups, some joints spherical, among soups at rest.
ArticulatedScene randomChainAmongSoups(Random& random)
{
    const int links = random.integer(2, 6);
    ArticulatedScene scene;
    scene.tree = randomBallTree(random, links, 0.1);
    scene.motion = randomJointMotion(random, scene.tree, random.logUniform(0.5, 4.0));
    for (int i = 0; i < links; ++i)
    {
        scene.linkMeshes.push_back(i == 0 ? TriangleMesh{}
                                          : scaled(soup(random, 4, 0.5, 0.7), 0.5));
    }
    for (int i = 0; i < 3; ++i)
    {
        const Vector3d place =
            scene.motion.root.X_W0.translation() + random.uniform(0.9, 2.2) * random.direction();
        scene.obstacles.push_back(soup(random, 4, 0.7, 0.8));
        scene.obstacleMotions.push_back(restAt(poseOf(place)));
    }
    return scene;
}

TEST(FirstOrder, FindsTheContactsOfTheQueryInMoreSteps)
{
    Random random(2310);
    int hits = 0;
    std::int64_t ours = 0;
    std::int64_t directional = 0;
    std::int64_t sum = 0;
    const auto effort = [](const ArticulatedToiResult& result)
    { return result.counters.nodePairs + result.counters.trianglePairs; };
    for (int i = 0; i < 400; ++i)
    {
        const ArticulatedScene scene = randomChainAmongSoups(random);
        const BuiltScene built(scene);
        const ToiOptions options{.tolerance = 1e-8};
        ToiWorkspace work;
        const ArticulatedToiResult expected =
            articulatedToi(built.body(), built.obstacles(), options, work);
        hits += expected.status == ToiStatus::Hit ? 1 : 0;
        ours += effort(expected);
        for (auto [bound, total] : {std::pair{FirstOrderBound::Directional, &directional},
                                    std::pair{FirstOrderBound::Sum, &sum}})
        {
            const ArticulatedToiResult result =
                firstOrderToi(built.body(), built.obstacles(), bound, options);
            *total += effort(result);
            ASSERT_EQ(result.status, expected.status) << i;
            // A graze within the tolerance may be met early; 1e-8 is reached in 1e-4 then.
            EXPECT_NEAR(result.time, expected.time, 1e-4) << i;
            if (expected.status == ToiStatus::Hit)
            {
                EXPECT_EQ(result.contacts.at(0).link, expected.contacts.at(0).link) << i;
                EXPECT_EQ(result.contacts.at(0).obstacle, expected.contacts.at(0).obstacle) << i;
            }
        }
    }
    EXPECT_GT(hits, 80);
    EXPECT_LT(2 * ours, directional);
    EXPECT_LT(directional, sum);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
