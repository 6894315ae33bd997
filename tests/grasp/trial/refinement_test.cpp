#include "grasp/trial/refinement.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

namespace bullet_ccd::grasp
{
namespace
{
HandModel strongGripper(bool coupled)
{
    HandModel hand = tests::makeGripper(coupled);
    for (Link& link : hand.robot.tree.links)
    {
        link.joint.maxEffort = 100.0;
    }
    return hand;
}

/// From below, with the jaws at the place.
Grasp closedAt(const HandModel& hand,
               const GraspObject& object,
               const Eigen::Vector3d& place,
               const PlannerOptions& options)
{
    return closeAtPose(hand,
                       object,
                       Eigen::Isometry3d(Eigen::Translation3d(place.x(), place.y(), -0.035)),
                       Eigen::Vector3d::Zero(),
                       hand.preshapes.front(),
                       options,
                       kinematicClosing());
}

TEST(CloseAtPose, JawsOnOneMotorAreCentredIfThatIsAskedFor)
{
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    const Eigen::Vector3d off(0.004, 0.0, 0.0);
    for (const bool coupled : {true, false})
    {
        const HandModel hand = strongGripper(coupled);
        const Grasp plain = closedAt(hand, cube, off, {});
        const Grasp centred = closedAt(hand, cube, off, {.centred = true});
        // Jaws with a motor each close until both touch.
        EXPECT_EQ(plain.reject == RejectReason::None, !coupled) << toString(plain.reject);
        EXPECT_EQ(centred.reject, RejectReason::None) << toString(centred.reject);
        EXPECT_NEAR(centred.X_WH.translation().x(), coupled ? 0.0 : 0.004, 2e-4);
    }
}

/// A bar of 0.3 kg that is held 50 mm beside its centre turns between two jaws.
TEST(Refinement, HoldsABarAtItsCentreAfterItTurnedBesideIt)
{
    const HandModel hand = strongGripper(false);
    const GraspObject bar = makeGraspObject("bar", makeBox({0.02, 0.08, 0.02}));
    const TrialOptions options{.squeeze = {.mass = 0.3, .friction = 0.5, .firmness = 4.0},
                               .friction = 0.15};
    const TrialProtocol six = shippedProtocol("six");
    Grasp beside = closedAt(hand, bar, {0.0, 0.05, 0.0}, {});
    ASSERT_EQ(beside.reject, RejectReason::None);
    beside.candidate = 7;
    const TrialResult lost = runTrial(hand, bar, beside, six, options);
    ASSERT_NE(lost.outcome, TrialOutcome::Held);
    ASSERT_NE(lost.outcome, TrialOutcome::NoSqueeze) << lost.reason;
    const Eigen::AngleAxisd turn(lost.moved.linear());
    EXPECT_TRUE(turn.angle() > six.heldTurn || lost.moved.translation().norm() > six.heldWay);
    const Grasp refined = refinedGrasp(hand, bar, beside, lost, {}, kinematicClosing());
    ASSERT_EQ(refined.reject, RejectReason::None);
    EXPECT_EQ(refined.candidate, 7);
    EXPECT_GT(refined.quality.largestMass, beside.quality.largestMass);
    EXPECT_LT(std::abs(refined.X_WH.translation().y()), 0.03);
    EXPECT_EQ(runTrial(hand, bar, refined, six, options).outcome, TrialOutcome::Held);
}
}  // namespace
}  // namespace bullet_ccd::grasp
