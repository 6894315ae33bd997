/// Closing motions followed through all their contacts.
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kContactTolerance = 1e-6;

ContactSequence follow(const ArticulatedScene& scene, StopRule rule = StopRule::Chain)
{
    const BuiltScene built(scene);
    ToiWorkspace work;
    ContactSequenceOptions options{.query = {.toi = {.tolerance = kContactTolerance}},
                                   .rule = rule};
    return articulatedContacts(built.body(), built.obstacles(), options, work);
}

/// Two phalanxes that close together on a wall below: the first stops, the second goes on.
ArticulatedScene fingerOverAStep()
{
    ArticulatedScene scene;
    scene.tree = planarChain({1.0, 1.0});
    scene.linkMeshes = {{}, segment({0, 0, 0}, {0.8, 0, 0}), segment({0, 0, 0}, {0.8, 0, 0})};
    scene.motion = {.root = {}, .positions = {0, 0, 0}, .rates = {0, -0.5, -1.5}};
    // A post that the first phalanx meets, and another that the second does.
    scene.obstacles = {segment({0.5, -0.1, -1}, {0.5, -0.1, 1}),
                       segment({1.2, -0.6, -1}, {1.2, -0.6, 1})};
    scene.obstacleMotions = {{}, {}};
    return scene;
}

TEST(ArticulatedContacts, TheDistalLinkGoesOnAfterTheProximalStops)
{
    const ContactSequence result = follow(fingerOverAStep());
    ASSERT_EQ(result.status, ToiStatus::Hit);
    ASSERT_EQ(result.contacts.size(), 2U);
    const double first = std::atan2(0.1, 0.5) / 0.5;
    EXPECT_EQ(result.contacts[0].link, 1);
    EXPECT_EQ(result.contacts[0].obstacle, 0);
    EXPECT_EQ(result.contacts[0].stopJoint, 1);
    EXPECT_NEAR(result.contacts[0].time, first, 1e-5);
    EXPECT_NEAR(result.stopTimes[1], first, 1e-5);
    // From then on the second turns alone about the end of the first, which points down by a.
    const double a = std::atan2(0.1, 0.5);
    const Eigen::Vector2d joint(std::cos(a), -std::sin(a));
    const Eigen::Vector2d toPost = Eigen::Vector2d(1.2, -0.6) - joint;
    const double direction = std::atan2(-toPost.y(), toPost.x());
    EXPECT_EQ(result.contacts[1].link, 2);
    EXPECT_EQ(result.contacts[1].obstacle, 1);
    EXPECT_EQ(result.contacts[1].stopJoint, 2);
    EXPECT_NEAR(result.contacts[1].time, (direction - a) / 1.5, 1e-4);
    EXPECT_EQ(result.time, 1.0);
    EXPECT_NEAR(result.end.positions[1], -a, 1e-5);
    EXPECT_NEAR(result.end.positions[2], -(direction - a), 1e-4);
    EXPECT_EQ(result.end.rates, (std::vector<double>{0, 0, 0}));
    EXPECT_EQ(result.queries, 2);
}

TEST(ArticulatedContacts, CoupledJointsStopTogether)
{
    ArticulatedScene scene = fingerOverAStep();
    scene.tree.links[2].joint.mimicOf = 1;
    scene.tree.links[2].joint.mimicMultiplier = 3.0;
    const ContactSequence result = follow(scene);
    ASSERT_EQ(result.contacts.size(), 1U);
    EXPECT_EQ(result.stopTimes[1], result.stopTimes[2]);
    EXPECT_NEAR(result.end.positions[2], 3.0 * result.end.positions[1], 1e-12);
}

TEST(ArticulatedContacts, OnlyTheNearestJointStopsIfAskedTo)
{
    // The second phalanx meets its post first; the first goes on and carries it off the post.
    ArticulatedScene scene = fingerOverAStep();
    scene.motion.rates = {0, 0.5, -2.0};
    scene.obstacles[0] = segment({0.5, 5, -1}, {0.5, 5, 1});
    scene.obstacles[1] = segment({1.5, -0.2, -1}, {1.5, -0.2, 1});
    const ContactSequence result = follow(scene, StopRule::NearestJoint);
    ASSERT_EQ(result.contacts.size(), 1U);
    EXPECT_EQ(result.contacts[0].stopJoint, 2);
    EXPECT_LT(result.stopTimes[2], 1.0);
    EXPECT_EQ(result.stopTimes[1], 1.0);
    EXPECT_NEAR(result.end.positions[1], 0.5, 1e-12);
    EXPECT_EQ(result.time, 1.0);
}

TEST(ArticulatedContacts, FingersThatMeetStopEachOther)
{
    // I08: mirrored fingers.
    ArticulatedScene scene;
    scene.tree = planarChain({0.08});
    scene.tree.links.push_back(planarChain({0.08}, {0.12, 0, 0}).links[1]);
    scene.linkMeshes = {{}, segment({0, 0, 0}, {0.08, 0, 0}), segment({0, 0, 0}, {0.08, 0, 0})};
    scene.motion = {.root = {}, .positions = {0, 1.2, std::acos(-1.0) - 1.2}, .rates = {0, -1, 1}};
    scene.selfPairs = {{1, 2}};
    const ContactSequence result = follow(scene);
    ASSERT_EQ(result.contacts.size(), 1U);
    EXPECT_NEAR(result.contacts[0].time, 1.2 - std::acos(0.12 / 0.16), 1e-4);
    EXPECT_EQ(result.stopTimes[1], result.stopTimes[2]);
    EXPECT_LT(result.stopTimes[1], 1.0);
}

TEST(ArticulatedContacts, AnObstacleThatPressesOnEndsTheSequence)
{
    ArticulatedScene scene;
    scene.tree = planarChain({1.0});
    scene.linkMeshes = {{}, segment({0, 0, 0}, {1, 0, 0})};
    scene.motion = {.root = {}, .positions = {0, 0}, .rates = {0, 0.5}};
    scene.obstacles = {floorAt(0.0, 1.0)};
    scene.obstacleMotions = {
        {.X_W0 = poseOf({0.5, 1.0, 0}, 1.5707963267948966, {1, 0, 0}), .v_W = {0, -2, 0}}};
    const ContactSequence result = follow(scene);
    EXPECT_EQ(result.status, ToiStatus::Hit);
    EXPECT_LT(result.time, 0.5);
    EXPECT_GE(result.contacts.size(), 1U);
    EXPECT_LE(result.queries, 4);
}

/// No link is within reach of an obstacle or of another link at any time of what came out.
TEST(ArticulatedContacts, RandomHandsNeverTouchOnTheirWay)
{
    Random random(2601);
    int contacts = 0;
    int several = 0;
    for (int i = 0; i < 80; ++i)
    {
        ArticulatedScene scene;
        const int fingers = random.integer(1, 4);
        scene.tree.links.resize(1);
        scene.linkMeshes.resize(1);
        scene.motion = {.root = {}, .positions = {0.0}, .rates = {0.0}};
        for (int f = 0; f < fingers; ++f)
        {
            const double place = 6.2831853 * f / fingers;
            std::int32_t parent = 0;
            for (int k = 0; k < 3; ++k)
            {
                Link link;
                link.parent = parent;
                link.X_PL0 = k == 0 ? poseOf({0.6 * std::cos(place), 0.6 * std::sin(place), 0.0},
                                             place,
                                             Eigen::Vector3d::UnitZ())
                                    : poseOf({0.0, 0.0, 0.45});
                link.joint.type = JointType::Revolute;
                link.joint.axis = -Eigen::Vector3d::UnitY();
                parent = static_cast<std::int32_t>(scene.tree.links.size());
                scene.tree.links.push_back(link);
                scene.linkMeshes.push_back(box({-0.05, -0.05, 0.03}, {0.05, 0.05, 0.42}));
                scene.motion.positions.push_back(random.uniform(-0.3, 0.1));
                scene.motion.rates.push_back(random.uniform(0.3, 1.2));
            }
        }
        scene.obstacles = {scaled(soup(random, 8, 0.5, 0.5), 0.5)};
        scene.obstacleMotions = {restAt(poseOf({0, 0, random.uniform(0.3, 0.9)}))};
        scene.selfPairs.clear();
        const ContactSequence result = follow(scene);
        ASSERT_TRUE(result.status == ToiStatus::Hit || result.status == ToiStatus::Separated ||
                    result.status == ToiStatus::Overlapping);
        if (result.status == ToiStatus::Overlapping)
        {
            continue;
        }
        contacts += static_cast<int>(result.contacts.size());
        several += result.contacts.size() > 2 ? 1 : 0;
        EXPECT_EQ(result.time, 1.0);
        for (int k = 0; k <= 15; ++k)
        {
            // The pose at a time follows from when each joint stopped.
            const double t = k / 15.0;
            JointMotion at = scene.motion;
            for (std::size_t j = 0; j < at.positions.size(); ++j)
            {
                at.positions[j] += std::min(t, result.stopTimes[j]) * at.rates[j];
                at.rates[j] = 0.0;
            }
            for (std::int32_t link = 1; link < static_cast<std::int32_t>(scene.tree.size()); ++link)
            {
                const auto index = static_cast<std::size_t>(link);
                const OracleBody a = oracleLink(scene.linkMeshes[index], scene.tree, at, link);
                const OracleBody b = oracleBody(scene.obstacles[0], scene.obstacleMotions[0]);
                ASSERT_GT(oracleDistanceAt(a, b, 0.0), 0.0) << i << " at " << t;
            }
        }
        for (std::size_t j = 0; j < scene.motion.positions.size(); ++j)
        {
            EXPECT_NEAR(result.end.positions[j],
                        scene.motion.positions[j] + result.stopTimes[j] * scene.motion.rates[j],
                        1e-12);
        }
    }
    EXPECT_GT(contacts, 80);
    EXPECT_GT(several, 10);
}

TEST(ArticulatedContacts, RefusesMotionsThatItCannotCut)
{
    struct Rest : UserMotion
    {
        [[nodiscard]] MotionState at(double /*t*/) const override { return {}; }
        [[nodiscard]] AccelerationBound accelerationBound() const override { return {}; }
    };
    const ArticulatedScene scene = fingerOverAStep();
    const BuiltScene built(scene);
    std::vector<RigidBody> obstacles = built.obstacles();
    const Rest rest;
    obstacles[0].userMotion = &rest;
    ToiWorkspace work;
    EXPECT_THROW((void)articulatedContacts(built.body(), obstacles, {}, work),
                 std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::tests
