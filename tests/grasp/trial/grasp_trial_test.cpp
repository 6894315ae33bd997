#include "grasp/trial/grasp_trial.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]

/// Two jaws at a cube of 40 mm, with a contact at each corner of their faces.
struct PinchedCube
{
    HandModel hand;
    GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    Grasp grasp;

    explicit PinchedCube(bool coupled, double effort) : hand(tests::makeGripper(coupled))
    {
        for (Link& link : hand.robot.tree.links)
        {
            link.joint.maxEffort = effort;
        }
        grasp.X_WH.translation() = Eigen::Vector3d(0.0, 0.0, -0.035);
        grasp.positions = {0.0, 0.01995, 0.01995};
        for (const double side : {-1.0, 1.0})
        {
            for (const double y : {-0.01, 0.01})
            {
                for (const double z : {-0.02, 0.02})
                {
                    grasp.contacts.push_back({.link = side < 0.0 ? 1 : 2,
                                              .point = {0.02 * side, y, z},
                                              .normal = {-side, 0.0, 0.0},
                                              .gap = 5e-5});
                }
            }
        }
    }

    [[nodiscard]] TrialOutcome outcome(TrialProtocol protocol, const SqueezeOptions& squeeze) const
    {
        const TrialResult result = runTrial(hand, cube, grasp, protocol, {.squeeze = squeeze});
        EXPECT_TRUE(result.penetration.clean());
        return result.outcome;
    }
};

TEST(Squeeze, OfTwoJawsIsHalfOfTheForceEach)
{
    const SqueezeOptions options{.mass = 0.3, .friction = 0.5};
    const double sum = options.firmness * 0.3 * kStandardGravity / 0.5;
    const PinchedCube free(false, 100.0);
    const Squeeze squeeze = squeezeOf(free.hand, free.grasp, options);
    ASSERT_TRUE(squeeze.exists()) << squeeze.reason;
    EXPECT_NEAR(squeeze.normalForce, sum, 1e-6 * sum);
    for (std::size_t j = 0; j < 2; ++j)
    {
        EXPECT_NEAR(squeeze.torques[j], 0.5 * sum, 1e-4 * sum);
        EXPECT_NEAR(squeeze.stiffness[j] * (squeeze.targets[j] - 0.01995), 0.5 * sum, 1e-4 * sum);
        EXPECT_FALSE(squeeze.efforts[j].isAssumed);
    }
    // One motor for both jaws gives all of it.
    const PinchedCube coupled(true, 100.0);
    const Squeeze one = squeezeOf(coupled.hand, coupled.grasp, options);
    ASSERT_EQ(one.torques.size(), 1U);
    EXPECT_NEAR(one.torques[0], sum, 1e-4 * sum);
}

TEST(Squeeze, SaysWhyThereIsNone)
{
    PinchedCube weak(false, 1.0);
    EXPECT_EQ(squeezeOf(weak.hand, weak.grasp, {.mass = 0.5}).reason.rfind("limits", 0), 0U);
    PinchedCube oneSided(false, 50.0);
    oneSided.grasp.contacts.resize(4);
    EXPECT_EQ(squeezeOf(oneSided.hand, oneSided.grasp, {}).reason.rfind("geometry", 0), 0U);
    oneSided.grasp.contacts.resize(1);
    EXPECT_FALSE(squeezeOf(oneSided.hand, oneSided.grasp, {}).exists());
    for (const double effort : {0.0, 1000.0, std::numeric_limits<double>::infinity()})
    {
        const PinchedCube strange(false, effort);
        EXPECT_TRUE(jointEfforts(strange.hand.robot.tree)[0].isAssumed);
    }
    EXPECT_THROW((void)squeezeOf(weak.hand, weak.grasp, {.mass = 0.0}), std::invalid_argument);
    EXPECT_THROW((void)squeezeOf(weak.hand, weak.grasp, {.friction = -1.0}), std::invalid_argument);
}

TEST(GraspTrial, TwoJawsHoldACubeInAllDirections)
{
    const PinchedCube pinched(false, 100.0);
    const SqueezeOptions squeeze{.mass = 0.3, .friction = 0.5};
    const TrialResult result = runTrial(
        pinched.hand, pinched.cube, pinched.grasp, TrialProtocol::Six, {.squeeze = squeeze});
    EXPECT_EQ(result.outcome, TrialOutcome::Held);
    EXPECT_TRUE(result.penetration.clean());
    EXPECT_GT(result.meanForce, 0.9 * 4.0 * 0.3 * kStandardGravity / 0.5);
    EXPECT_EQ(pinched.outcome(TrialProtocol::Shake, squeeze), TrialOutcome::Held);
    const TrialResult again = runTrial(
        pinched.hand, pinched.cube, pinched.grasp, TrialProtocol::Six, {.squeeze = squeeze});
    EXPECT_EQ(result.slip, again.slip);
    EXPECT_EQ(result.peakForce, again.peakForce);
}

TEST(GraspTrial, SaysHowItFails)
{
    // Contacts that are not there make the squeeze.
    PinchedCube far(false, 100.0);
    far.grasp.positions = {0.0, 0.0, 0.0};
    far.grasp.X_WH.translation() = Eigen::Vector3d(0.0, 0.3, 0.0);
    EXPECT_EQ(far.outcome(TrialProtocol::Hover, {.mass = 0.3}), TrialOutcome::NeverTouched);
    PinchedCube weak(false, 1.0);
    EXPECT_EQ(weak.outcome(TrialProtocol::Six, {.mass = 5.0}), TrialOutcome::NoSqueeze);
    weak.grasp.positions.clear();
    EXPECT_THROW((void)weak.outcome(TrialProtocol::Six, {}), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
