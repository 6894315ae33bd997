#include "grasp/planner/pose_noise.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "grasp/planner/grasp_planner.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
/// Two jaws with an opening of 80 mm around a bar of 60 mm: 10 mm of room on either side.
class PoseNoiseTest : public ::testing::Test
{
protected:
    PoseNoiseTest()
    {
        Eigen::Isometry3d X_WStart = Eigen::Isometry3d::Identity();
        X_WStart.translation().z() = -0.2;
        m_grasp = closeAtPose(m_hand,
                              m_bar,
                              X_WStart,
                              {0.0, 0.0, 0.16},
                              m_hand.preshapes.front(),
                              m_options,
                              kinematicClosing());
    }

    [[nodiscard]] PoseRobustness repeated(const PoseNoise& noise) const
    {
        return poseRobustness(m_hand, m_bar, m_grasp, noise, m_options, kinematicClosing());
    }

    HandModel m_hand = tests::makeGripper(false);
    GraspObject m_bar = makeGraspObject("bar", makeBox({0.03, 0.02, 0.03}));
    PlannerOptions m_options{.volumes = 0};
    Grasp m_grasp;
};

TEST_F(PoseNoiseTest, WithoutNoiseEveryTrialIsTheGrasp)
{
    ASSERT_EQ(m_grasp.reject, RejectReason::None);
    const PoseRobustness result = repeated({.position = 0.0, .rotation = 0.0, .trials = 5});
    EXPECT_EQ(result.trials, 5);
    EXPECT_EQ(result.forceClosures, 5);
    EXPECT_EQ(result.sameLinks, 5);
    ASSERT_EQ(result.epsilons.size(), 5U);
    for (const double epsilon : result.epsilons)
    {
        EXPECT_NEAR(epsilon, m_grasp.quality.epsilon, 1e-9);
    }
}

TEST_F(PoseNoiseTest, JawsHoldTheBarAsLongAsItIsBetweenThem)
{
    // One millimetre never takes a jaw's 10 mm of room; 2 degrees neither.
    const PoseRobustness little = repeated({.position = 1e-3, .rotation = 0.01, .trials = 40});
    EXPECT_EQ(little.sameLinks, 40);
    // Of an error of 30 mm across the jaws only what is below 10 mm leaves room: erf(1 / (3 sqrt
    // 2)) = 26 %, and errors in the other directions only take from that.
    const PoseRobustness much = repeated({.position = 0.03, .rotation = 0.0, .trials = 200});
    EXPECT_LT(much.forceClosures, 200 * 0.26 + 3.0 * std::sqrt(200 * 0.26 * 0.74));
    EXPECT_GT(much.forceClosures, 0) << "the test is vacuous";
    EXPECT_TRUE(std::is_sorted(much.epsilons.begin(), much.epsilons.end()));
}

TEST_F(PoseNoiseTest, TheSeedDecides)
{
    const PoseNoise noise{.position = 0.005, .rotation = 0.0, .trials = 10, .seed = 3};
    EXPECT_EQ(repeated(noise).epsilons, repeated(noise).epsilons);
    PoseNoise other = noise;
    other.seed = 4;
    EXPECT_NE(repeated(noise).epsilons, repeated(other).epsilons);
}

TEST_F(PoseNoiseTest, RefusesWhatMakesNoSense)
{
    EXPECT_THROW(static_cast<void>(repeated({.position = -1.0})), std::invalid_argument);
    m_grasp.preshape = "fist";
    EXPECT_THROW(static_cast<void>(repeated({})), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
