/// The smallest distance over a motion: closed forms, and brute force over random motions.
#include "bullet_ccd/toi/least_distance.h"

#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

LeastDistanceResult ask(const RigidScene& scene, const LeastDistanceOptions& options)
{
    const SsvTree a = buildSsvTree(scene.meshA);
    const SsvTree b = buildSsvTree(scene.meshB);
    ToiWorkspace work;
    return leastDistance(RigidBody{.tree = &a, .motion = scene.motionA},
                         RigidBody{.tree = &b, .motion = scene.motionB},
                         options,
                         work);
}

/// The answer is complete and right.
void expectLeast(const LeastDistanceResult& result, double truth, double tolerance)
{
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_LE(result.distance, truth + 1e-14);
    EXPECT_GE(result.distance, truth - 1.01 * tolerance);
    EXPECT_GE(result.found, truth - 1e-14);
    EXPECT_LE(result.found, result.distance + 1.01 * tolerance);
    EXPECT_NEAR((result.pointB - result.pointA).norm(), result.found, 1e-12);
}

TEST(LeastDistance, OfACubeThatFliesPastACubeIsTheGapBesideIt)
{
    const RigidScene scene{.meshA = cube(0.5),
                           .meshB = cube(0.5),
                           .motionA = {.X_W0 = poseOf({-3, 1.3, 0.1}), .v_W = {6, 0, 0}}};
    for (const double tolerance : {1e-3, 1e-6, 1e-9})
    {
        const LeastDistanceResult result = ask(scene, {.tolerance = tolerance});
        expectLeast(result, 0.3, tolerance);
        EXPECT_NEAR(std::abs(result.normal.y()), 1.0, 1e-9);
        EXPECT_GT(result.time, 1.0 / 3.0 - 1e-9);
        EXPECT_LT(result.time, 2.0 / 3.0 + 1e-9);
        EXPECT_LE(result.queries, 3);
    }
}

/// An arm of length r turns by an angle, and its tip passes a wall. The hull of its first and last
/// pose, which planners take for the motion, is off by the sagitta r (1 - cos(angle / 2)).
TEST(LeastDistance, OfAnArcIsExactWhereTheHullOfItsEndsIsMillimetresOff)
{
    constexpr double kClearance = 3e-3;
    for (const auto& [radius, degrees, sagitta] : {std::array{0.5, 10.0, 1.9e-3},
                                                   {0.5, 20.0, 7.6e-3},
                                                   {1.0, 10.0, 3.8e-3},
                                                   {1.0, 20.0, 15.2e-3}})
    {
        const double angle = degrees * std::numbers::pi / 180.0;
        ASSERT_NEAR(radius * (1.0 - std::cos(0.5 * angle)), sagitta, 0.05e-3);
        const RigidScene scene{
            .meshA = sphereWithPole(0.01, Vector3d::UnitX()),
            .meshB = wallAtX(radius + 0.01 + kClearance, 2.0),
            .motionA = {.X_W0 = poseOf(Vector3d::Zero(), -0.5 * angle), .w_W = {0, 0, angle}}};
        // The ball is at the end of the arm: its mesh is shifted along the arm.
        RigidScene arm = scene;
        arm.meshA = shifted(scene.meshA, {radius, 0, 0});
        const LeastDistanceResult result = ask(arm, {.tolerance = 1e-7});
        expectLeast(result, kClearance, 1e-7);
        EXPECT_NEAR(result.time, 0.5, 1e-3);
    }
}

TEST(LeastDistance, IsZeroWhereTheSurfacesIntersect)
{
    const RigidScene scene{.meshA = cube(0.5),
                           .meshB = cube(0.5),
                           .motionA = {.X_W0 = poseOf({-3, 0.2, 0.1}), .v_W = {6, 0, 0}}};
    const LeastDistanceResult result = ask(scene, {});
    EXPECT_EQ(result.status, ToiStatus::Overlapping);
    EXPECT_EQ(result.distance, 0.0);
    EXPECT_EQ(result.found, 0.0);
    EXPECT_TRUE(result.normal.isZero());
}

TEST(LeastDistance, IsNotLookedForBeyondWhatIsEnough)
{
    const RigidScene scene{.meshA = cube(0.5),
                           .meshB = cube(0.5),
                           .motionA = {.X_W0 = poseOf({-3, 1.3, 0.1}), .v_W = {6, 0, 0}}};
    const LeastDistanceResult clear = ask(scene, {.tolerance = 1e-6, .enough = 0.2});
    EXPECT_EQ(clear.distance, 0.2);
    EXPECT_EQ(clear.found, 0.2);
    EXPECT_EQ(clear.pair, kNone);
    EXPECT_EQ(clear.queries, 1);
    expectLeast(ask(scene, {.tolerance = 1e-6, .enough = 0.4}), 0.3, 1e-6);
    // What is enough is within the tolerance of the truth, on either side.
    for (const double enough : {0.3 - 1e-7, 0.3, 0.3 + 1e-7})
    {
        const LeastDistanceResult result = ask(scene, {.tolerance = 1e-6, .enough = enough});
        EXPECT_EQ(result.status, ToiStatus::Separated);
        EXPECT_LE(result.distance, 0.3);
        EXPECT_GE(result.distance, 0.3 - 1.3e-6);
    }
}

TEST(LeastDistance, OfRandomMotionsIsThatOfDenseSamples)
{
    constexpr int kSteps = 400;
    const int rounds = longTests() ? 1000 : 60;
    Random random(5);
    int apart = 0;
    int queries = 0;
    for (int i = 0; i < rounds; ++i)
    {
        SCOPED_TRACE(i);
        const RigidScene scene = randomRigidScene(random);
        const double tolerance = random.uniform(0.0, 1.0) < 0.5 ? 1e-3 : 1e-6;
        const LeastDistanceResult result = ask(scene, {.tolerance = tolerance});
        const SsvTree a = buildSsvTree(scene.meshA);
        const SsvTree b = buildSsvTree(scene.meshB);
        double least = kInfinity;
        for (int k = 0; k <= kSteps; ++k)
        {
            const double t = double(k) / kSteps;
            const Eigen::Isometry3d X_BA =
                scene.motionB.at(t).X_W.inverse() * scene.motionA.at(t).X_W;
            least = std::min(least, treeDistance(a, b, X_BA, least).distance);
        }
        // No sample is nearer than what is certified, and what was found is there.
        EXPECT_LE(result.distance, least + roundingOf(scene));
        const Eigen::Isometry3d X_BA =
            scene.motionB.at(result.time).X_W.inverse() * scene.motionA.at(result.time).X_W;
        EXPECT_NEAR(treeDistance(a, b, X_BA, kInfinity).distance, result.found, roundingOf(scene));
        EXPECT_NE(result.status, ToiStatus::IterationLimit);
        EXPECT_LE(result.found - result.distance, 1.01 * tolerance);
        apart += result.distance > 0.0 ? 1 : 0;
        queries += result.queries;
    }
    EXPECT_GT(apart, rounds / 5);
    EXPECT_LT(apart, rounds - rounds / 10);
    EXPECT_LT(queries, 4 * rounds);
}

TEST(LeastDistance, OfChainsIsThatOfDenseSamples)
{
    constexpr int kSteps = 60;
    const std::uint64_t rounds = longTests() ? 10 * kChainRound : kChainRound;
    int apart = 0;
    int ofLinks = 0;
    for (std::uint64_t seed = 0; seed < rounds; ++seed)
    {
        SCOPED_TRACE(seed);
        const ChainQuery chain = chainQuery(seed);
        const BuiltScene built(chain.scene);
        const ArticulatedBody body = built.body();
        ToiWorkspace work;
        const ArticulatedLeastDistance result =
            leastDistance(body, built.obstacles(), {.tolerance = 1e-5, .enough = 10.0}, work);
        EXPECT_NE(result.status, ToiStatus::IterationLimit);
        EXPECT_LE(result.found - result.distance, 1.01e-5);
        const auto poseAt = [&](std::int32_t link, double t)
        { return linkStateAt(*body.tree, *body.motion, kNone, link, t).X_W; };
        double least = 10.0;
        for (int k = 0; k <= kSteps; ++k)
        {
            const double t = double(k) / kSteps;
            for (std::size_t i = 0; i < body.tree->size(); ++i)
            {
                const auto link = static_cast<std::int32_t>(i);
                for (const RigidBody& obstacle : built.obstacles())
                {
                    const bool isAtRest = !moves(*body.tree, *body.motion, kNone, link) &&
                                          obstacle.motion.v_W.isZero(0.0) &&
                                          obstacle.motion.w_W.isZero(0.0);
                    if (body.linkTrees[i] != nullptr && !isAtRest)
                    {
                        const Eigen::Isometry3d X_BA =
                            obstacle.motion.at(t).X_W.inverse() * poseAt(link, t);
                        least = std::min(
                            least,
                            treeDistance(*body.linkTrees[i], *obstacle.tree, X_BA, least).distance);
                    }
                }
            }
            for (const auto& [a, b] : body.selfPairs)
            {
                const std::int32_t base = commonAncestor(*body.tree, a, b);
                if (!moves(*body.tree, *body.motion, base, a) &&
                    !moves(*body.tree, *body.motion, base, b))
                {
                    continue;
                }
                const Eigen::Isometry3d X_BA = poseAt(b, t).inverse() * poseAt(a, t);
                least = std::min(least,
                                 treeDistance(*body.linkTrees[static_cast<std::size_t>(a)],
                                              *body.linkTrees[static_cast<std::size_t>(b)],
                                              X_BA,
                                              least)
                                     .distance);
            }
        }
        EXPECT_LE(result.distance, least + 1e-12);
        apart += result.distance > 0.0 ? 1 : 0;
        ofLinks += result.otherLink != kNone ? 1 : 0;
        EXPECT_TRUE(result.link != kNone || result.found == 10.0);
    }
    EXPECT_GT(apart, 10);
    EXPECT_GT(ofLinks, 3);
}

TEST(LeastDistance, RefusesWhatIsNoQuestion)
{
    const RigidScene scene{.meshA = cube(0.5), .meshB = cube(0.5)};
    EXPECT_THROW((void)ask(scene, {.tolerance = 0.0}), std::invalid_argument);
    EXPECT_THROW((void)ask(scene, {.enough = -1.0}), std::invalid_argument);
    EXPECT_THROW((void)ask(scene, {.enough = std::nan("")}), std::invalid_argument);
    ToiWorkspace work;
    EXPECT_THROW((void)leastDistance({}, std::span<const BodyPair>{}, {}, work),
                 std::invalid_argument);
    EXPECT_EQ(leastDistance({}, std::span<const BodyPair>{}, {.enough = 2.0}, work).distance, 2.0);
    RigidScene broken = scene;
    broken.motionA.v_W.x() = std::nan("");
    EXPECT_THROW((void)ask(broken, {}), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::tests
