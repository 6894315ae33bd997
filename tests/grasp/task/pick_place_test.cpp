/// Plans of pick and place, looked at by samples that share nothing with the certificates.
#include "grasp/task/pick_place.h"

#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/task/plan_file.h"
#include "grasp/task/task_legs.h"
#include "grasp/trial/plan_execution.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <limits>
#include <memory>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;

Eigen::Isometry3d at(double x, double y, double z)
{
    return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// The arm with the parallel gripper at a table, on which a box of 4 x 6 x 8 cm stands. A wall
/// stands on the straight way of the arm from there to the target.
struct Kitchen
{
    HandModel hand = loadHand(BULLET_CCD_SHARE "/robots/parallel_gripper/parallel_gripper.urdf");
    RobotModel arm = loadRobot(BULLET_CCD_SHARE "/robots/arms/seven_joint_arm.urdf");
    ArmRobot robot = mountHand(arm, hand, "", Eigen::Isometry3d::Identity());
    SsvTree table = buildSsvTree(makeBox({0.45, 1.1, 0.02}));
    SsvTree wall = buildSsvTree(makeBox({0.2, 0.01, 0.2}));
    GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.04}));
    std::vector<RigidBody> obstacles{{.tree = &table, .motion = restAt(at(0.62, 0.0, -0.02))},
                                     {.tree = &wall, .motion = restAt(at(0.6, 0.05, 0.2))}};
    std::vector<double> start{0.0, -0.3, 0.0, -1.6, 0.0, 1.2, 0.0};
    PickPlaceOptions options;

    Kitchen() { options.grasps.candidates = 24; }
    Kitchen(const Kitchen&) = delete;

    [[nodiscard]] PickPlaceTask task() const
    {
        return {.hand = hand,
                .robot = robot,
                .start = start,
                .object = object,
                .X_WO = at(0.5, -0.2, 0.04),
                .obstacles = obstacles,
                .obstacleNames = {"table", "wall"},
                .target = {.center = {0.5, 0.3, 0.0}, .size = {0.1, 0.1}}};
    }
};

const Kitchen& kitchen()
{
    static const Kitchen theKitchen;
    return theKitchen;
}

const PickPlacePlan& thePlan()
{
    static const PickPlacePlan plan = planPickPlace(kitchen().task(), kitchen().options);
    return plan;
}

/// Positions at a time between two waypoints at rest: the polynomial of fifth degree.
std::vector<double> between(const Waypoint& from, const Waypoint& to, double part)
{
    const double s = part * part * part * (10.0 + part * (6.0 * part - 15.0));
    std::vector<double> q = from.positions;
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        q[i] += s * (to.positions[i] - q[i]);
    }
    return q;
}

TEST(PickPlace, KeepsItsCertifiedClearanceAtDenseSamples)
{
    const PickPlacePlan& plan = thePlan();
    ASSERT_TRUE(plan.solved) << plan.failure;
    ASSERT_EQ(plan.legs.size(), 9U);
    for (std::size_t i = 0; i < plan.legs.size(); ++i)
    {
        const TaskLeg& leg = plan.legs[i];
        EXPECT_GT(leg.clearance, 0.0) << leg.name;
        const int samples = tests::longTests() ? 2000 : 40;
        EXPECT_GE(sampledDistance(kitchen().task(), plan, i, samples), leg.clearance) << leg.name;
    }
}

TEST(PickPlace, SamplesSeeWhatIsInTheWay)
{
    // The wall where the object is carried along: the check above would find a contact.
    const PickPlacePlan& plan = thePlan();
    ASSERT_TRUE(plan.solved) << plan.failure;
    const TaskLeg& carry = plan.legs[4];
    ASSERT_EQ(carry.name, "carry");
    const auto X_W = linkPoses(kitchen().robot.tree,
                               Eigen::Isometry3d::Identity(),
                               between(carry.waypoints[0], carry.waypoints[1], 0.5));
    const auto root = static_cast<std::size_t>(kitchen().robot.handRoot);
    const RigidBody wall{.tree = &kitchen().wall, .motion = restAt(X_W[root] * plan.X_HO)};
    PickPlaceTask blocked = kitchen().task();
    blocked.obstacles = std::span(&wall, 1);
    EXPECT_EQ(sampledDistance(blocked, plan, 4, 20), 0.0);
}

TEST(PickPlace, LegsFollowOnEachOtherWithinTheLimits)
{
    const PickPlacePlan& plan = thePlan();
    ASSERT_TRUE(plan.solved) << plan.failure;
    const KinematicTree& tree = kitchen().robot.tree;
    for (std::size_t i = 0; i < plan.legs.size(); ++i)
    {
        const std::vector<Waypoint>& way = plan.legs[i].waypoints;
        if (i > 0)
        {
            EXPECT_EQ(way.front().time, plan.legs[i - 1].waypoints.back().time);
            for (std::size_t k = 0; k < tree.size(); ++k)
            {
                EXPECT_NEAR(way.front().positions[k],
                            plan.legs[i - 1].waypoints.back().positions[k],
                            1e-12);
            }
        }
        for (std::size_t w = 1; w < way.size(); ++w)
        {
            constexpr int kSamples = 50;
            const double step = (way[w].time - way[w - 1].time) / kSamples;
            ASSERT_GT(step, 0.0);
            for (int s = 1; s < kSamples; ++s)
            {
                const auto q = [&](int n)
                { return between(way[w - 1], way[w], double(n) / kSamples); };
                const std::vector<double> before = q(s - 1);
                const std::vector<double> here = q(s);
                const std::vector<double> after = q(s + 1);
                for (std::size_t k = 1; k < tree.size(); ++k)
                {
                    const Joint& joint = tree.links[k].joint;
                    EXPECT_GE(here[k], joint.lower - 1e-9);
                    EXPECT_LE(here[k], joint.upper + 1e-9);
                    EXPECT_LE(std::abs(after[k] - before[k]) / (2.0 * step),
                              std::min(joint.maxVelocity, 1e3) * (1.0 + 1e-9));
                    EXPECT_LE(std::abs(after[k] - 2.0 * here[k] + before[k]) / (step * step),
                              kitchen().options.acceleration * (1.0 + 1e-6));
                }
            }
        }
    }
    for (std::size_t k = 0; k < 7; ++k)  // it returns to where it began
    {
        const auto joint = static_cast<std::size_t>(kitchen().robot.joints[k]);
        EXPECT_NEAR(
            plan.legs.front().waypoints.front().positions[joint], kitchen().start[k], 1e-12);
        EXPECT_NEAR(plan.legs.back().waypoints.back().positions[joint], kitchen().start[k], 1e-12);
    }
}

/// A box of 4 x 6 x 8 cm that stands on the plane z = 0 and is carried along an axis by 2 cm.
struct CarriedBox
{
    GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.04}));
    ArmRobot robot;
    NamedSurroundings around;

    [[nodiscard]] Parting part(const Eigen::Vector3d& axis, double overlap = 1e-4)
    {
        robot.tree.links = {{.name = "base"}, {.name = "slide", .parent = 0}};
        robot.tree.links[1].joint.type = JointType::Prismatic;
        robot.tree.links[1].joint.axis = axis.normalized();
        robot.linkTrees = {nullptr, nullptr};
        robot.handRoot = 1;
        around.finish();
        RobotBody body(robot);
        body.carry(robot, object, at(0.0, 0.0, 0.04));
        TaskLeg leg;
        for (const double time : {0.0, 1.0})
        {
            leg.waypoints.push_back({.time = time,
                                     .positions = {0.0, 0.02 * time},
                                     .velocities = {0.0, 0.0},
                                     .accelerations = {0.0, 0.0}});
        }
        ToiWorkspace work;
        return certifyParting(
            body, Eigen::Isometry3d::Identity(), around, leg, 1e-4, overlap, work);
    }
};

/// Surfaces that touch where the object stands may part, and nothing else is left out.
TEST(CertifyParting, LeavesOutOnlyWhatTouchesAndParts)
{
    const SsvTree table = buildSsvTree(makeBox({0.45, 1.1, 0.02}));
    const SsvTree block = buildSsvTree(makeBox({0.1, 0.1, 0.1}));
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
    const auto boxOn = [&](const Eigen::Isometry3d& X_WT)
    {
        auto box = std::make_unique<CarriedBox>();
        box->around.add(table, X_WT, "table");
        return box;
    };
    const Eigen::Isometry3d below = at(0.0, 0.0, -0.02);
    for (const Eigen::Isometry3d& X_WT : {below, at(0.45, 0.0, -0.02), at(0.44, 0.3, -0.02)})
    {
        const Parting lifted = boxOn(X_WT)->part(up);  // also over an edge of the table
        EXPECT_EQ(lifted.objection, "");
        EXPECT_EQ(lifted.from, std::vector<std::string>{"table"});
    }
    EXPECT_EQ(boxOn(below)->part(x + 0.2 * up).objection, "");
    EXPECT_THAT(boxOn(below)->part(-up).objection, HasSubstr("does not part from table"));
    EXPECT_THAT(boxOn(below)->part(x).objection, HasSubstr("does not part from table"));
    // Half a millimetre inside.
    const Eigen::Isometry3d inside = at(0.0, 0.0, -0.0195);
    EXPECT_THAT(boxOn(inside)->part(up).objection, HasSubstr("does not part from table"));
    EXPECT_EQ(boxOn(inside)->part(up, 1e-3).objection, "");
    // Where it touches nothing, there is nothing to part from.
    EXPECT_TRUE(boxOn(at(0.0, 0.0, -0.021))->part(-up).from.empty());
    const auto under = boxOn(below);
    under->around.add(block, at(0.0, 0.0, 0.19), "shelf");  // a centimetre above
    EXPECT_THAT(under->part(up).objection, HasSubstr("box touches shelf"));
    const auto leaning = boxOn(below);
    leaning->around.add(block, at(0.12, 0.0, 0.1), "wall");
    EXPECT_THAT(leaning->part(up).objection, HasSubstr("does not part from wall"));
}

TEST(PickPlace, IsLiftedFromWhereItStands)
{
    const PickPlacePlan& plan = thePlan();
    ASSERT_TRUE(plan.solved) << plan.failure;
    EXPECT_EQ(plan.partsFrom, std::vector<std::string>{"table"});
}

TEST(PickPlace, TheObjectStandsInTheTarget)
{
    const PickPlacePlan& plan = thePlan();
    ASSERT_TRUE(plan.solved) << plan.failure;
    const PickPlaceTask task = kitchen().task();
    EXPECT_LE(std::abs(plan.X_WOEnd.translation().x() - 0.5), 0.05);
    EXPECT_LE(std::abs(plan.X_WOEnd.translation().y() - 0.3), 0.05);
    // 0.1 mm above the table, and upright.
    EXPECT_NEAR(plan.X_WOEnd.translation().z(), 0.0401, 2e-5);
    EXPECT_NEAR(plan.X_WOEnd.linear()(2, 2), 1.0, 1e-8);
    EXPECT_NEAR(plan.X_WOStart.translation().z(), 0.0401, 2e-5);
}

TEST(PickPlace, WorksOutInASimulation)
{
    if (!tests::longTests())
    {
        GTEST_SKIP() << "takes ten seconds: tools/check --all runs it";
    }
    const PickPlacePlan& plan = thePlan();
    ASSERT_TRUE(plan.solved) << plan.failure;
    const ExecutionResult done = executePlan(kitchen().task(), plan);
    EXPECT_TRUE(done.succeeded) << done.reason;
    EXPECT_LT(done.missed, 0.01);
    EXPECT_GT(done.leastDistance, 0.0);
    // Fingers without friction do not lift it, and something else is said.
    const ExecutionResult slips = executePlan(kitchen().task(), plan, {.friction = 1e-3});
    EXPECT_FALSE(slips.succeeded);
    EXPECT_FALSE(slips.reason.empty());
}

/// Jaws that reach around it nearly to the table, on one motor: the first one that touches stops
/// both.
TEST(PickPlace, ASmallCubeIsTakenFromATable)
{
    const GraspObject cube = makeGraspObject("cube", makeBox({0.02, 0.02, 0.02}));
    const PickPlaceTask task = kitchen().task();
    const std::vector<RigidBody> table{kitchen().obstacles.front()};
    const PickPlacePlan plan =
        planPickPlace({.hand = task.hand,
                       .robot = task.robot,
                       .start = task.start,
                       .object = cube,
                       .X_WO = at(0.45, 0.0, 0.02),
                       .obstacles = table,
                       .obstacleNames = {"table"},
                       .target = {.center = {0.45, 0.2, 0.0}, .size = {0.1, 0.1}}});
    EXPECT_TRUE(plan.solved) << plan.failure;
    EXPECT_GE(plan.grasp.contacts.size(), 2U);
    for (const TaskAttempt& attempt : plan.attempts)
    {
        EXPECT_NE(attempt.leg, "close") << attempt.candidate << ": " << attempt.reason;
    }
}

/// A tray wider than the jaws open, with a wall at two sides: it is taken by one of them.
TEST(PickPlace, WhatIsTooWideIsTakenByItsRim)
{
    TriangleMesh mesh = makeBox({0.07, 0.07, 0.002});
    for (const double side : {-0.067, 0.067})
    {
        TriangleMesh wall = makeBox({0.003, 0.07, 0.02});
        transformMesh(wall, Eigen::Affine3d(Eigen::Translation3d(side, 0.0, 0.0179)));
        appendMesh(mesh, wall);
    }
    const GraspObject tray = makeGraspObject("tray", mesh);
    const PickPlaceTask task = kitchen().task();
    const std::vector<RigidBody> table{kitchen().obstacles.front()};
    PickPlaceOptions options = kitchen().options;
    options.grasps.mass = 0.1;
    const PickPlacePlan plan =
        planPickPlace({.hand = task.hand,
                       .robot = task.robot,
                       .start = task.start,
                       .object = tray,
                       .X_WO = at(0.45, 0.0, 0.002),
                       .obstacles = table,
                       .obstacleNames = {"table"},
                       .target = {.center = {0.45, 0.25, 0.0}, .size = {0.1, 0.1}}},
                      options);
    ASSERT_TRUE(plan.solved) << plan.failure;
    for (const GraspContact& contact : plan.grasp.contacts)
    {
        EXPECT_GT(std::abs(contact.point.x()), 0.06);
    }
}

TEST(PickPlace, PutsDownOnAnotherFaceWhatDoesNotFitAsItStood)
{
    // 6 x 8 cm, 4 cm high; the target is a slot of 5 cm between two rails on a pedestal.
    const Kitchen& k = kitchen();
    const GraspObject block = makeGraspObject("block", makeBox({0.03, 0.04, 0.02}));
    const SsvTree pedestal = buildSsvTree(makeBox({0.05, 0.05, 0.1}));
    const SsvTree rail = buildSsvTree(makeBox({0.005, 0.05, 0.0075}));
    const SsvTree stand = buildSsvTree(makeBox({0.025, 0.025, 0.05}));
    const std::vector<RigidBody> bodies{{.tree = &k.table, .motion = restAt(at(0.62, 0.0, -0.02))},
                                        {.tree = &pedestal, .motion = restAt(at(0.5, 0.3, 0.1))},
                                        {.tree = &rail, .motion = restAt(at(0.47, 0.3, 0.2075))},
                                        {.tree = &rail, .motion = restAt(at(0.53, 0.3, 0.2075))},
                                        {.tree = &stand, .motion = restAt(at(0.5, -0.2, 0.05))}};
    const PickPlaceTask task{.hand = k.hand,
                             .robot = k.robot,
                             .start = k.start,
                             .object = block,
                             .X_WO = at(0.5, -0.2, 0.12),
                             .obstacles = bodies,
                             .obstacleNames = {"table", "pedestal", "rail a", "rail b", "stand"},
                             .target = {.center = {0.5, 0.3, 0.2}, .size = {0.004, 0.01}}};
    PickPlaceOptions options;
    options.grasps.mass = 0.192;
    const PickPlacePlan plan = planPickPlace(task, options);
    ASSERT_TRUE(plan.solved) << plan.failure;
    // It lies on one of its sides, between the rails.
    const Eigen::Matrix3d R = plan.X_WOEnd.linear();
    EXPECT_NEAR(R.row(2).cwiseAbs().maxCoeff(), 1.0, 1e-5);
    EXPECT_LT(std::abs(R(2, 2)), 1e-5);
    EXPECT_LT((plan.X_WOEnd.translation() - Eigen::Vector3d(0.5, 0.3, 0.2)).head<2>().norm(), 6e-3);
    const double half = std::abs(R(2, 0)) > 0.5 ? 0.03 : 0.04;
    EXPECT_NEAR(plan.X_WOEnd.translation().z(), 0.2 + half + 1e-4, 2e-5);
    for (std::size_t leg = 0; leg < plan.legs.size(); ++leg)
    {
        EXPECT_GE(sampledDistance(task, plan, leg, 40), plan.legs[leg].clearance);
    }
    options.placesOnOtherFaces = false;
    EXPECT_THAT(planPickPlace(task, options).failure, HasSubstr("no room"));
}

TEST(PickPlace, SaysWhyThereIsNoPlan)
{
    const Kitchen& k = kitchen();
    PickPlaceTask far = k.task();
    far.target.center = {0.8, 0.95, 0.0};  // on the table, and too far for the arm
    const PickPlacePlan none = planPickPlace(
        far, {.grasps = k.options.grasps, .graspsTried = 1, .placesOnOtherFaces = false});
    EXPECT_FALSE(none.solved);
    EXPECT_THAT(none.failure, HasSubstr("grasps that were tried (1)"));
    ASSERT_EQ(none.attempts.size(), 1U);
    for (const TaskAttempt& attempt : none.attempts)
    {
        EXPECT_FALSE(attempt.leg.empty());
        EXPECT_FALSE(attempt.reason.empty());
    }
    PickPlaceTask farther = k.task();
    farther.target.center = {0.8, 2.9, 0.0};
    const SsvTree ground = buildSsvTree(makeBox({4.0, 4.0, 0.05}));
    std::vector<RigidBody> onGround{{.tree = &ground, .motion = restAt(at(0.0, 0.0, -0.05))}};
    farther.obstacles = onGround;
    farther.obstacleNames = {"ground"};
    farther.X_WR.translation().z() += 0.01;
    const PickPlacePlan outOfReach = planPickPlace(farther, k.options);
    EXPECT_THAT(outOfReach.failure, HasSubstr("the target region is out of reach"));
    EXPECT_TRUE(outOfReach.attempts.empty());
    EXPECT_NEAR(outOfReach.startHeight, 0.0, 1e-4);
    farther.X_WO = at(0.8, 2.9, 0.09);
    const PickPlacePlan floating = planPickPlace(farther, k.options);
    EXPECT_THAT(floating.failure, HasSubstr("box is out of reach"));
    EXPECT_NEAR(floating.startHeight, 0.05, 2e-4);  // less the gap
    PickPlaceTask beside = k.task();
    beside.target.center = {0.5, 2.0, 0.0};  // there is no table
    EXPECT_THAT(planPickPlace(beside, k.options).failure, HasSubstr("nothing below"));
    PickPlaceTask under = k.task();
    under.target.center = {0.6, 0.05, 0.0};  // within the wall
    under.target.size = {0.0, 0.0};
    EXPECT_THAT(planPickPlace(under, k.options).failure, HasSubstr("no room"));
    const SsvTree block = buildSsvTree(makeBox({0.15, 0.15, 0.15}));
    PickPlaceTask inside = k.task();
    std::vector<RigidBody> covered = k.obstacles;
    covered.push_back({.tree = &block, .motion = restAt(at(0.5, 0.3, 0.149))});
    inside.obstacles = covered;
    inside.obstacleNames = {"table", "wall", "block"};
    EXPECT_THAT(planPickPlace(inside, k.options).failure, HasSubstr("no room"));
    const std::atomic<bool> cancelled = true;
    PickPlaceOptions stopped = k.options;
    stopped.stop.isCancelled = &cancelled;
    const PickPlacePlan ended = planPickPlace(k.task(), stopped);
    EXPECT_FALSE(ended.solved);
    EXPECT_TRUE(ended.stopped);
}

TEST(MountHand, GivesEachLinkANameOfItsOwn)
{
    const Kitchen& k = kitchen();
    RobotModel arm = loadRobot(BULLET_CCD_SHARE "/robots/arms/seven_joint_arm.urdf");
    const std::string& name = k.hand.robot.tree.links[1].name;
    arm.tree.links[1].name = name;
    arm.tree.links[2].name = "hand_" + name;
    const ArmRobot robot = mountHand(arm, k.hand, "", Eigen::Isometry3d::Identity());
    std::set<std::string> names;
    for (const Link& link : robot.tree.links)
    {
        EXPECT_TRUE(names.insert(link.name).second) << link.name;
    }
}

TEST(PickPlace, RefusesBadInput)
{
    const Kitchen& k = kitchen();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto message = [&](const std::function<void(PickPlaceTask&)>& change)
    {
        PickPlaceTask task = k.task();
        change(task);
        try
        {
            (void)planPickPlace(task, k.options);
        }
        catch (const std::invalid_argument& error)
        {
            return std::string(error.what());
        }
        return std::string("nothing was thrown");
    };
    EXPECT_THAT(message([](PickPlaceTask& t) { t.X_WO = at(0.5, -0.2, 0.02); }),
                HasSubstr("box intersects table"));
    EXPECT_THAT(message([](PickPlaceTask& t) { t.start.pop_back(); }), HasSubstr("start position"));
    EXPECT_THAT(message([&](PickPlaceTask& t) { t.start[1] = nan; }), HasSubstr("not finite"));
    EXPECT_THAT(message([&](PickPlaceTask& t) { t.target.center.x() = nan; }),
                HasSubstr("not finite"));
    EXPECT_THAT(message([&](PickPlaceTask& t) { t.X_WO.translation().x() = nan; }),
                HasSubstr("not finite"));
    EXPECT_THAT(message([](PickPlaceTask& t) { t.obstacleNames.pop_back(); }),
                HasSubstr("one name"));
    EXPECT_THAT(message([](PickPlaceTask& t) { t.start[1] = 1.9; }),
                HasSubstr("in collision where it starts"));
    try
    {
        (void)mountHand(k.arm, k.hand, "flansh", Eigen::Isometry3d::Identity());
        ADD_FAILURE() << "the arm has no such link";
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_THAT(error.what(), HasSubstr("no link 'flansh'"));
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
