/// Two hands: what is claimed of their plans is computed anew.
#include "grasp/task/two_hands.h"

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/task/plan_file.h"
#include "grasp/task/single_hand.h"
#include "grasp/trial/two_hands_execution.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;

Eigen::Isometry3d placedAt(double x, double y, double z)
{
    return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// Two arms with the three-finger gripper, 0.9 m apart, before a board on which a barrel stands.
struct Pair
{
    HandModel hand =
        loadHand(BULLET_CCD_SHARE "/robots/three_finger_gripper/three_finger_gripper.urdf");
    RobotModel arm = loadRobot(BULLET_CCD_SHARE "/robots/arms/seven_joint_arm.urdf");
    ArmRobot robot = mountHand(arm, hand, "", Eigen::Isometry3d::Identity());
    TwoArms arms = joinArms({PlacedArm{&hand, &robot, placedAt(0.0, 0.45, 0.0)},
                             PlacedArm{&hand, &robot, placedAt(0.0, -0.45, 0.0)}});
    SsvTree board = buildSsvTree(makeBox({0.2, 0.06, 0.01}));
    GraspObject object =
        makeGraspObject("barrel", loadMeshFile(BULLET_CCD_SHARE "/objects/large/barrel.obj").mesh);
    RigidBody stand{.tree = &board, .motion = restAt(placedAt(0.55, 0.0, 0.34))};
    TwoHandOptions options;

    Pair() { options.common.grasps.candidates = 120; }
    Pair(const Pair&) = delete;

    [[nodiscard]] TwoHandTask task() const
    {
        const std::vector<double> start(7, 0.0);
        return {.arms = arms,
                .start = {start, start},
                .object = object,
                .X_WO = placedAt(0.55, 0.0, 0.35),
                .obstacles = std::span(&stand, 1),
                .obstacleNames = {"stand"}};
    }
};

const Pair& bothArms()
{
    static const Pair theTwo;
    return theTwo;
}

const TwoHandPlan& theLift()
{
    static const TwoHandPlan plan = planTwoHands(bothArms().task(), bothArms().options);
    return plan;
}

TEST(TwoArms, AreWhereEachArmIsByItself)
{
    const TwoArms& arms = bothArms().arms;
    const std::vector<double> left{0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7};
    const std::vector<double> right{-0.7, 0.6, -0.5, 0.4, -0.3, 0.2, -0.1};
    const std::vector<double>& open = bothArms().hand.preshapes.front().positions;
    const auto X_W = linkPoses(arms.whole.robot.tree,
                               Eigen::Isometry3d::Identity(),
                               arms.positions({left, right}, {open, open}));
    for (std::size_t side = 0; side < 2; ++side)
    {
        const ArmRobot& robot = bothArms().robot;
        std::vector<double> q(robot.tree.size(), 0.0);
        std::copy(open.begin(), open.end(), q.begin() + robot.handRoot);
        for (std::size_t k = 0; k < 7; ++k)
        {
            q[static_cast<std::size_t>(robot.joints[k])] = (side == 0 ? left : right)[k];
        }
        applyMimics(robot.tree, q);
        const auto X_WAlone = linkPoses(robot.tree, arms.arms[side].X_WR, q);
        for (std::size_t i = 0; i < X_WAlone.size(); ++i)
        {
            const auto link =
                static_cast<std::size_t>(arms.linkOf(side, static_cast<std::int32_t>(i)));
            EXPECT_TRUE(X_W[link].isApprox(X_WAlone[i], 1e-12)) << i;
        }
    }
    EXPECT_EQ(arms.efforts.size(), independentJoints(arms.whole.robot.tree).size());
    EXPECT_EQ(arms.joints().size(), 14U);
}

TEST(TwoHands, HoldTogetherWhatNeitherHoldsAlone)
{
    const TwoHandPlan& plan = theLift();
    ASSERT_TRUE(plan.solved) << plan.failure;
    EXPECT_GE(plan.grasp.quality.epsilon, 0.005);
    EXPECT_EQ(plan.aloneEpsilon[0], 0.0);
    EXPECT_EQ(plan.aloneEpsilon[1], 0.0);
    // The squeeze balances itself within friction and the efforts of all joints.
    const TwoArms& arms = bothArms().arms;
    Eigen::Vector3d left = Eigen::Vector3d::Zero();
    Eigen::Vector3d all = Eigen::Vector3d::Zero();
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < plan.grasp.contacts.size(); ++i)
    {
        const GraspContact& contact = plan.grasp.contacts[i];
        const Eigen::Vector3d& force = plan.squeeze.forces[i];
        const double normal = force.dot(contact.normal);
        EXPECT_GE(normal, 0.0);
        EXPECT_LE((force - normal * contact.normal).norm(), 0.5 * normal + 1e-6);
        all += force;
        moment += contact.point.cross(force);
        left += contact.link < arms.first[1] ? force : Eigen::Vector3d::Zero();
    }
    EXPECT_LT(all.norm(), 1e-6 * plan.forces.squeeze);
    EXPECT_LT(moment.norm(), 1e-6 * plan.forces.squeeze);
    EXPECT_NEAR(left.norm(), plan.forces.internal, 1e-9);
    EXPECT_GT(plan.forces.internal, 1.0);
    for (std::size_t j = 0; j < arms.efforts.size(); ++j)
    {
        EXPECT_LE(std::abs(plan.squeeze.torques[j]), arms.efforts[j] * (1.0 + 1e-9));
    }
    EXPECT_LE(plan.forces.effort, 1.0);
    EXPECT_GE(*plan.grasp.quality.largestMass, 2.0 * plan.mass.mass);
}

TEST(TwoHands, KeepTheirCertifiedClearanceAtDenseSamples)
{
    const TwoHandPlan& plan = theLift();
    ASSERT_TRUE(plan.solved) << plan.failure;
    ASSERT_EQ(plan.legs.size(), 4U);
    for (std::size_t i = 0; i < plan.legs.size(); ++i)
    {
        const TaskLeg& leg = plan.legs[i];
        EXPECT_GT(leg.clearance, 0.0) << leg.name;
        const int samples = tests::longTests() ? 1000 : 20;
        EXPECT_GE(sampledDistance(bothArms().task(), plan, i, samples), leg.clearance) << leg.name;
    }
    // 0.2 m straight up, with both hands where they hold the object to a tenth of a millimetre.
    const TaskLeg& lift = plan.legs.back();
    const KinematicTree& tree = bothArms().arms.whole.robot.tree;
    const TaskState end = stateAt(bothArms().task(), plan, lift.waypoints.back().time);
    EXPECT_NEAR(end.X_WO.translation().z() - plan.X_WOStart.translation().z(), 0.2, 1e-6);
    const auto between = [&](double time)
    {
        const TaskState state = stateAt(bothArms().task(), plan, time);
        return Eigen::Vector3d(
            state.X_W[static_cast<std::size_t>(bothArms().arms.handRoot(0))].translation() -
            state.X_W[static_cast<std::size_t>(bothArms().arms.handRoot(1))].translation());
    };
    const double begin = lift.waypoints.front().time;
    for (int i = 0; i <= 200; ++i)
    {
        const double time = begin + (lift.waypoints.back().time - begin) * i / 200;
        EXPECT_LT((between(time) - between(begin)).norm(), 2e-4);
    }
    EXPECT_EQ(tree.size(), end.X_W.size());
}

TEST(TwoHands, LiftInASimulationAndLoseItWithoutFriction)
{
    if (!tests::longTests())
    {
        GTEST_SKIP() << "takes ten seconds: tools/check --all runs it";
    }
    const TwoHandPlan& plan = theLift();
    ASSERT_TRUE(plan.solved) << plan.failure;
    const LiftResult lifted = executeLift(bothArms().task(), plan);
    EXPECT_TRUE(lifted.succeeded) << lifted.reason;
    EXPECT_NEAR(lifted.risen, 0.2, 0.01);
    EXPECT_GT(lifted.leastDistance, 0.0);
    const LiftResult lost = executeLift(bothArms().task(), plan, {.friction = 0.01});
    EXPECT_FALSE(lost.succeeded);
    EXPECT_GT(lost.missed, 0.02);
}

TEST(TwoHands, SayWhyThereIsNoPlan)
{
    TwoHandTask far = bothArms().task();
    far.X_WO = placedAt(5.0, 0.0, 0.35);
    TwoHandOptions few = bothArms().options;
    few.common.grasps.candidates = 4;
    const TwoHandPlan plan = planTwoHands(far, few);
    EXPECT_FALSE(plan.solved);
    EXPECT_THAT(plan.failure, HasSubstr("brings its hand to no candidate"));
    std::ostringstream json;
    writeLiftJson(json, far, plan);
    EXPECT_THAT(json.str(), HasSubstr("\"solved\": false"));
}

TEST(SingleHand, HoldsACanButFindsNoForceClosureOfABarrelAndNoneOfATrayThatHoldsIt)
{
    const auto searched = [](const std::string& name)
    {
        PickPlaceOptions options;
        options.grasps.candidates = 30;
        return searchSingleHand(
            bothArms().hand,
            makeGraspObject(name, loadMeshFile(BULLET_CCD_SHARE "/objects/" + name + ".obj").mesh),
            options);
    };
    const SingleHandSearch can = searched("can");
    EXPECT_EQ(can.candidates, 60);
    EXPECT_GT(can.holding, 5);
    EXPECT_GE(can.forceClosures, can.holding);
    EXPECT_GT(can.largestMass, 0.5);
    const SingleHandSearch barrel = searched("large/barrel");
    EXPECT_EQ(barrel.forceClosures, 0);
    EXPECT_EQ(barrel.holding, 0);
    const SingleHandSearch tray = searched("large/tray");
    EXPECT_GT(tray.forceClosures, 0);
    EXPECT_GT(tray.largestMass, 0.1);
    EXPECT_EQ(tray.holding, 0);
}

/// Why the task is refused after a change.
std::string refusedWhen(const std::function<void(TwoHandTask&)>& change,
                        const TwoHandOptions& options = {})
{
    TwoHandTask task = bothArms().task();
    change(task);
    try
    {
        static_cast<void>(planTwoHands(task, options));
    }
    catch (const std::invalid_argument& error)
    {
        return error.what();
    }
    return "accepted";
}

TEST(TwoHands, RefuseBadInput)
{
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(refusedWhen([](TwoHandTask& task) { task.X_WO = placedAt(0.55, 0.0, 0.34); }),
                HasSubstr("barrel intersects stand"));
    EXPECT_THAT(refusedWhen([](TwoHandTask& task) { task.X_WO = placedAt(0.0, 0.45, 0.9); }),
                HasSubstr("in collision where it starts"));
    EXPECT_THAT(refusedWhen([](TwoHandTask& task) { task.X_WO.translation().x() = kNaN; }),
                HasSubstr("not finite"));
    EXPECT_THAT(refusedWhen([](TwoHandTask& task) { task.start[0][2] = kNaN; }),
                HasSubstr("not finite"));
    EXPECT_THAT(refusedWhen([](TwoHandTask& task) { task.start[1].pop_back(); }),
                HasSubstr("one start position for each joint"));
    EXPECT_THAT(refusedWhen([](TwoHandTask& task) { task.obstacleNames.clear(); }),
                HasSubstr("one name for each obstacle"));
    TwoHandOptions flat;
    flat.common.lift = 0.0;
    EXPECT_THAT(refusedWhen([](TwoHandTask&) {}, flat), HasSubstr("must be positive"));
}
}  // namespace
}  // namespace bullet_ccd::grasp
