#include "grasp/sim/trial_world.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/sim/resting_dispatcher.h"
#include "tests/grasp/planner/test_hands.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kGravity = 9.81;      // [m/s^2]
constexpr double kStep = 1.0 / 240.0;  // [s]
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMargin = 5e-5;  // of each surface [m]
const Eigen::Vector3d kNoForce = Eigen::Vector3d::Zero();

/// How far one gets in `seconds` from rest; a step integrates its velocity first.
double fall(double acceleration, double seconds)
{
    return 0.5 * acceleration * seconds * (seconds + kStep);
}

/// Two jaws of 50 g on a cube of 40 mm: one holds its place, the other presses.
struct Pinch
{
    HandModel hand = tests::makeGripper(false);
    GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    std::unique_ptr<TrialWorld> world;

    Pinch(double mass, double friction, double force)
    {
        for (Link& link : hand.robot.tree.links)
        {
            link.mass = 0.05;
            link.centerOfMass = Eigen::Vector3d(0.0, 0.0, 0.03);
            link.inertia = 1e-5 * Eigen::Matrix3d::Identity();
        }
        const double closed = 0.02 - 1.6 * kMargin;  // jaws rest on the cube there
        const Eigen::Isometry3d X_WH(Eigen::Translation3d(0.0, 0.0, -0.035));
        world = std::make_unique<TrialWorld>(hand,
                                             cube,
                                             TrialBodies{.mass = mass, .friction = friction},
                                             X_WH,
                                             std::vector<double>{0.0, closed, closed});
        world->drive(
            1, {.effort = 2000.0, .stiffness = 1e6, .damping = 1e4, .maxSpeed = 1.0}, closed);
        world->drive(2,
                     {.effort = force, .stiffness = 1e6, .damping = 1e3, .maxSpeed = 0.1},
                     force > 0.0 ? 0.039 : closed);
    }

    /// Without weight first, until everything rests.
    void settle() const { run(0.25, Eigen::Vector3d::Zero()); }

    void run(double seconds, const Eigen::Vector3d& acceleration) const
    {
        for (int k = 0; k < std::lround(seconds / kStep); ++k)
        {
            world->step(kStep, acceleration, kNoForce);
        }
    }
};

/// How far the cube has gone after `seconds` under its weight, across the jaws.
double slipOf(double mass, double friction, double share, double seconds)
{
    const Pinch pinch(mass, friction, share * mass * kGravity / (2.0 * friction));
    pinch.settle();
    const Eigen::Vector3d before = pinch.world->objectCenter();
    pinch.run(seconds, Eigen::Vector3d(0.0, -kGravity, 0.0));
    return (pinch.world->objectCenter() - before).norm();
}

TEST(TrialWorld, TwoJawsSlipWhereTheirFrictionIsTheWeight)
{
    for (const double mass : {0.02, 2.0})
    {
        for (const double friction : {0.2, 0.8})
        {
            EXPECT_LT(slipOf(mass, friction, 1.02, 0.25), 1e-6) << mass << " " << friction;
            // The friction that is missing accelerates it.
            const double expected = fall(0.02 * kGravity, 0.25);
            EXPECT_NEAR(slipOf(mass, friction, 0.98, 0.25), expected, 0.05 * expected)
                << mass << " " << friction;
        }
    }
}

/// The same with one motor for both jaws, and with skins that give way.
double coupledSlipOf(double mass, double friction, double share, double seconds)
{
    HandModel hand = tests::makeGripper(true);
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    const double closed = 0.02 - 4e-4;  // the cube fits between the skins
    const Eigen::Isometry3d X_WH(Eigen::Translation3d(0.0, 0.0, -0.035));
    TrialWorld world(hand,
                     cube,
                     {.mass = mass, .friction = friction, .margin = 2e-4, .stiffness = 5e4},
                     X_WH,
                     {0.0, closed, closed});
    const double motor = share * mass * kGravity / friction;  // of which each jaw has half
    world.drive(1, {.effort = motor, .stiffness = 1e6, .damping = 1e3, .maxSpeed = 0.1}, 0.039);
    const auto run = [&](double time, const Eigen::Vector3d& acceleration)
    {
        for (int k = 0; k < std::lround(time / kStep); ++k)
        {
            world.step(kStep, acceleration, kNoForce);
        }
    };
    run(0.25, Eigen::Vector3d::Zero());
    const Eigen::Vector3d before = world.objectCenter();
    run(seconds, Eigen::Vector3d(0.0, -kGravity, 0.0));
    return (world.objectCenter() - before).norm();
}

TEST(TrialWorld, CoupledJawsSlipWhereTheFrictionOfTheirMotorIsTheWeight)
{
    for (const double mass : {0.05, 1.0})
    {
        for (const double friction : {0.2, 0.8})
        {
            EXPECT_LT(coupledSlipOf(mass, friction, 1.02, 0.25), 1e-5) << mass << " " << friction;
            const double expected = fall(0.02 * kGravity, 0.25);
            EXPECT_NEAR(coupledSlipOf(mass, friction, 0.98, 0.25), expected, 0.05 * expected)
                << mass << " " << friction;
        }
    }
}

/// A jaw with a rim around its pad, which the cube fits into with room.
TriangleMesh cagingJaw()
{
    constexpr double kRoom = 0.0205;  // half of the cage
    TriangleMesh jaw = makeBox(Eigen::Vector3d(0.004, 0.03, 0.03));
    const auto add = [&](const Eigen::Vector3d& half, const Eigen::Vector3d& center)
    {
        TriangleMesh rim = makeBox(half);
        transformMesh(rim, Eigen::Affine3d(Eigen::Translation3d(center)));
        appendMesh(jaw, rim);
    };
    for (const double side : {-1.0, 1.0})
    {
        add({0.012, 0.004, 0.03}, {0.0, side * (kRoom + 0.004), 0.0});
        add({0.012, 0.03, 0.004}, {0.0, 0.0, side * (kRoom + 0.004)});
    }
    return jaw;
}

TEST(TrialWorld, AFormClosureHoldsWithoutFriction)
{
    HandModel hand = tests::makeGripper(false);
    for (const std::size_t jaw : {1U, 2U})
    {
        hand.robot.linkMeshes[jaw] = cagingJaw();
        hand.trees[jaw] = buildSsvTree(cagingJaw());
        hand.robot.tree.links[jaw].X_PL0.translation().z() = 0.035;
    }
    hand.selfPairs.clear();
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    const Eigen::Isometry3d X_WH(Eigen::Translation3d(0.0, 0.0, -0.035));
    TrialWorld world(hand, cube, {.mass = 0.5, .friction = 0.0}, X_WH, {0.0, 0.0205, 0.0205});
    for (const std::int32_t jaw : {1, 2})
    {
        world.drive(
            jaw, {.effort = 50.0, .stiffness = 1e5, .damping = 1e3, .maxSpeed = 1.0}, 0.0205);
    }
    for (int direction = 0; direction < 6; ++direction)
    {
        const double size = direction % 2 == 0 ? kGravity : -kGravity;
        for (int k = 0; k < 60; ++k)
        {
            world.step(kStep, size * Eigen::Vector3d::Unit(direction / 2), kNoForce);
        }
        EXPECT_LT(world.objectCenter().norm(), 1.5e-3) << direction;
    }
}

/// A jaw with one point, which looks along +-x.
TriangleMesh pointedJaw(double side)
{
    TriangleMesh mesh;
    mesh.vertices = {{side * 0.005, 0.0, 0.0}};
    for (const auto& [y, z] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    {
        mesh.vertices.emplace_back(-side * 0.005, 0.005 * y, 0.005 * z);
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {1, 3, 2}, {1, 4, 3}};
    if (side < 0.0)
    {
        for (Triangle& triangle : mesh.triangles)
        {
            std::swap(triangle[1], triangle[2]);
        }
    }
    return mesh;
}

/// A cube held at two points, d above its centre, swings about the line between them with the
/// period 2 pi sqrt((I + m d^2) / (m g d)) and keeps its amplitude: friction at a point resists no
/// turn.
TEST(TrialWorld, ACubeSwingsAboutTwoPointsAsAPendulum)
{
    constexpr double kDistance = 0.012;  // [m]
    constexpr double kTilt = 0.1;        // of gravity: half of the way that it swings [rad]
    HandModel hand = tests::makeGripper(false);
    for (const std::size_t jaw : {1U, 2U})
    {
        hand.robot.linkMeshes[jaw] = pointedJaw(jaw == 1 ? 1.0 : -1.0);
        hand.trees[jaw] = buildSsvTree(hand.robot.linkMeshes[jaw]);
        hand.robot.tree.links[jaw].X_PL0.translation().y() = kDistance;
        hand.robot.tree.links[jaw].X_PL0.translation().z() = 0.035;
    }
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    const double closed = 0.02 - 1.6 * kMargin;
    TrialWorld world(hand,
                     cube,
                     {.mass = 0.3, .friction = 1.0},
                     Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.035)),
                     {0.0, closed, closed});
    world.drive(1, {.effort = 2000.0, .stiffness = 1e6, .damping = 1e4, .maxSpeed = 1.0}, closed);
    world.drive(2, {.effort = 20.0, .stiffness = 1e6, .damping = 1e3, .maxSpeed = 0.1}, 0.039);
    for (int k = 0; k < 60; ++k)
    {
        world.step(kStep, Eigen::Vector3d::Zero(), kNoForce);
    }
    const Eigen::Vector3d gravity =
        kGravity * Eigen::Vector3d(0.0, -std::cos(kTilt), std::sin(kTilt));
    std::vector<double> turns;  // when it turns back [s]
    std::vector<double> angles;
    double before = 0.0;
    for (int k = 0; turns.size() < 6 && k < 480; ++k)
    {
        world.step(kStep, gravity, kNoForce);
        const double spin = world.objectSpin().x();
        if (k > 2 && before * spin < 0.0)
        {
            turns.push_back((k + 1 - spin / (spin - before)) * kStep);
            angles.push_back(Eigen::AngleAxisd(world.objectPose().linear()).angle());
        }
        before = spin;
    }
    ASSERT_EQ(turns.size(), 6U);
    const double inertia = 0.04 * 0.04 / 6.0;  // per mass
    const double period = 2.0 * std::numbers::pi *
                          std::sqrt((inertia + kDistance * kDistance) / (kGravity * kDistance));
    EXPECT_NEAR(turns[4] - turns[0], 2.0 * period, 0.02 * 2.0 * period);
    EXPECT_NEAR(angles[0], 2.0 * kTilt, 0.05 * 2.0 * kTilt);
    EXPECT_NEAR(angles[4], angles[0], 0.05 * angles[0]);
}

TEST(TrialWorld, SkinsGiveWayByTheirStiffnessAndGetHarder)
{
    // Four corners carry the weight of a cube on a table.
    const auto compressed = [](double mass)
    {
        HandModel hand = tests::makeGripper(false);
        const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
        TrialWorld world(hand,
                         cube,
                         {.mass = mass, .friction = 0.5, .margin = 5e-4, .stiffness = 1e4},
                         Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.5, 0.0)),
                         {0.0, 0.0, 0.0});
        world.addTable(Eigen::Vector3d(0.0, -0.021, 0.0), Eigen::Vector3d::UnitY());
        for (int k = 0; k < 240; ++k)
        {
            world.step(kStep, Eigen::Vector3d(0.0, -kGravity, 0.0), kNoForce);
        }
        EXPECT_LT(world.objectVelocity().norm(), 1e-5) << mass;
        return -world.objectCenter().y() - 2e-5;  // they rest by so much below the gap
    };
    // Each point bears k d / (1 - d / D)^2, and the same number of them bears every weight.
    constexpr double kDepth = 5.5e-4;
    double before = 0.0;  // force per mass
    for (const double mass : {0.1, 0.3, 1.0, 10.0, 100.0})
    {
        const double d = compressed(mass);
        EXPECT_LT(d, kDepth);
        const double force = 1e4 * d / std::pow(1.0 - d / kDepth, 2.0);
        EXPECT_GT(force, mass * kGravity / 9.0) << d;
        EXPECT_LT(force, mass * kGravity / 3.9) << d;
        if (before > 0.0)
        {
            EXPECT_NEAR(force / mass / before, 1.0, 0.03) << mass;
        }
        before = force / mass;
    }
}

TEST(TrialWorld, WhatHoldsDoesNotCreep)
{
    const double seconds = tests::longTests() ? 60.0 : 10.0;
    for (const double mass : {0.02, 2.0})
    {
        const Pinch pinch(mass, 0.5, 1.2 * mass * kGravity);
        pinch.settle();
        const Eigen::Isometry3d before = pinch.world->objectPose();
        pinch.run(seconds, Eigen::Vector3d(0.0, -kGravity, 0.0));
        const Eigen::Isometry3d moved = before.inverse() * pinch.world->objectPose();
        EXPECT_LT(moved.translation().norm(), 1e-4);
        EXPECT_LT(Eigen::AngleAxisd(moved.linear()).angle(), 0.1 * kDegree);
        EXPECT_LT(pinch.world->objectEnergy(), 1e-12);
        // The drive gives its force, and the cube gets it from both sides.
        EXPECT_NEAR(pinch.world->torque(2), 1.2 * mass * kGravity, 1e-3 * mass);
        EXPECT_NEAR(pinch.world->holdingForces().sum, 2.4 * mass * kGravity, 1e-3 * mass);
    }
}

/// Jaws at the end of an arm of 0.5 m that turns about `axis` by 5 rad. Points that went straight
/// on in each step would take the cube 16 mm out of the jaws; a millimetre is what its skins and
/// some impacts leave it, less where it does not turn about the line through the jaws.
void expectNoSlipOnAnArc(const Eigen::Vector3d& axis, double slip)
{
    constexpr double kArm = 0.5;    // [m]
    constexpr double kSpeed = 3.0;  // [rad/s]
    const HandModel gripper = tests::makeGripper(false);
    const Eigen::Isometry3d X_AH(Eigen::Translation3d(0.0, 0.0, kArm));
    HandModel hand;
    hand.linkTrees = {nullptr, nullptr};
    hand.robot.tree.links.resize(2);
    Link& arm = hand.robot.tree.links[1];
    arm.parent = 0;
    arm.joint = {.name = "arm", .type = JointType::Revolute, .axis = axis};
    for (std::size_t i = 0; i < gripper.robot.tree.size(); ++i)
    {
        Link link = gripper.robot.tree.links[i];
        link.X_PL0 = i == 0 ? X_AH : link.X_PL0;
        link.parent = i == 0 ? 1 : link.parent + 2;
        hand.robot.tree.links.push_back(link);
        hand.linkTrees.push_back(gripper.linkTrees[i]);
    }
    for (Link& link : hand.robot.tree.links)
    {
        link.mass = 0.05;
        link.inertia = 1e-5 * Eigen::Matrix3d::Identity();
    }
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    const double closed = 0.02 - 4e-4;  // the cube fits between the skins
    const Eigen::Isometry3d X_WR(Eigen::Translation3d(0.0, 0.0, -0.035 - kArm));
    TrialWorld world(hand,
                     cube,
                     {.mass = 0.2, .friction = 0.5, .margin = 2e-4, .stiffness = 5e4},
                     X_WR,
                     {0.0, 0.0, 0.0, closed, closed});
    world.drive(3, {.effort = 2000.0, .stiffness = 1e6, .damping = 1e4, .maxSpeed = 1.0}, closed);
    world.drive(4, {.effort = 40.0, .stiffness = 1e6, .damping = 1e3, .maxSpeed = 0.1}, 0.039);
    const auto cubeInJaws = [&]
    {
        return Eigen::Isometry3d(linkPoses(hand.robot.tree, X_WR, world.positions())[2].inverse() *
                                 world.objectPose());
    };
    Eigen::Isometry3d before = cubeInJaws();
    for (int k = 0; k < 500; ++k)
    {
        const double speed = kSpeed * std::min(1.0, 2.0 * k * kStep);
        const double now = world.positions()[1];
        world.drive(1,
                    {.effort = 1e4, .stiffness = 1e6, .damping = 1e4, .maxSpeed = 10.0},
                    now + speed * (kStep + 0.01));
        world.step(kStep, Eigen::Vector3d::Zero(), kNoForce);
        before = k == 120 ? cubeInJaws() : before;
    }
    EXPECT_GT(world.positions()[1], 4.0);
    const Eigen::Isometry3d moved = before.inverse() * cubeInJaws();
    EXPECT_LT(moved.translation().norm(), slip) << moved.translation().transpose();
    EXPECT_LT(Eigen::AngleAxisd(moved.linear()).angle(), 0.5 * kDegree);
}

TEST(TrialWorld, WhatIsCarriedAlongAnArcDoesNotSlip)
{
    expectNoSlipOnAnArc(Eigen::Vector3d::UnitX(), 1e-3);
    expectNoSlipOnAnArc(Eigen::Vector3d::UnitY(), 1e-4);
    expectNoSlipOnAnArc(Eigen::Vector3d(1.0, 2.0, 1.0).normalized(), 1e-4);
}

TEST(TrialWorld, DropsWhatIsTooSlipperyOrNotHeld)
{
    const Pinch slippery(0.5, 0.05, 10.0);  // 1 N of friction for 4.9 N
    slippery.settle();
    slippery.run(0.1, Eigen::Vector3d(0.0, -kGravity, 0.0));
    EXPECT_NEAR(slippery.world->objectCenter().y(), -fall(kGravity - 2.0, 0.1), 1e-3);
    const Pinch open(0.5, 0.5, 0.0);
    open.run(0.1, Eigen::Vector3d(0.0, -kGravity, 0.0));
    EXPECT_NEAR(open.world->objectCenter().y(), -fall(kGravity, 0.1), 1e-6);
}

TEST(TrialWorld, ASheetFallsAsEverything)
{
    TriangleMesh sheet;
    sheet.vertices = {
        {0.0, -0.02, -0.02}, {0.0, 0.02, -0.02}, {0.0, 0.02, 0.02}, {0.0, -0.02, 0.02}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    const GraspObject object = makeGraspObject("sheet", std::move(sheet));
    const HandModel hand = tests::makeGripper(false);
    TrialWorld world(hand,
                     object,
                     {.mass = 0.01, .friction = 0.5},
                     Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.035)),
                     {0.0, 0.0, 0.0});
    for (int k = 0; k < 24; ++k)
    {
        world.step(kStep, Eigen::Vector3d(0.0, -kGravity, 0.0), kNoForce);
    }
    EXPECT_NEAR(world.objectCenter().y(), -fall(kGravity, 0.1), 1e-6);
}

TEST(TrialWorld, ATableHoldsByFrictionUpToItsAngle)
{
    constexpr double kFriction = 0.4;
    for (const double share : {0.98, 1.02})
    {
        const Pinch pinch(0.5, kFriction, 0.0);
        pinch.world->addTable(Eigen::Vector3d(0.0, -0.02 - 2.0 * kMargin, 0.0),
                              Eigen::Vector3d::UnitY());
        const double angle = std::atan(share * kFriction);
        pinch.run(0.25, Eigen::Vector3d(0.0, -kGravity, 0.0));
        const double before = pinch.world->objectCenter().z();
        pinch.run(0.25, kGravity * Eigen::Vector3d(0.0, -std::cos(angle), std::sin(angle)));
        const double slid = pinch.world->objectCenter().z() - before;
        const double expected = fall(0.02 * kFriction * kGravity * std::cos(angle), 0.25);
        EXPECT_NEAR(slid, share > 1.0 ? expected : 0.0, share > 1.0 ? 0.05 * expected : 1e-6);
    }
}

TEST(TrialWorld, NothingBouncesAndNothingGainsEnergy)
{
    const Pinch pinch(0.5, 0.5, 0.0);
    pinch.world->addTable(Eigen::Vector3d(0.0, -0.03, 0.0),
                          Eigen::Vector3d(0.1, 1.0, 0.05).normalized());
    const double start = pinch.world->objectCenter().y();
    double lowest = start;
    for (int k = 0; k < 240; ++k)
    {
        pinch.world->step(kStep, Eigen::Vector3d(0.0, -kGravity, 0.0), kNoForce);
        const double height = pinch.world->objectCenter().y() - start;
        const double energy = pinch.world->objectEnergy() + 0.5 * kGravity * height;
        // A step integrates a fall a little too fast.
        EXPECT_LT(energy, 0.5 * 0.5 * std::pow(kGravity * kStep, 2.0));
        lowest = std::min(lowest, pinch.world->objectCenter().y());
    }
    EXPECT_LT(lowest, start - 0.005);
}

/// Restitution 0: what falls flat has no speed after its impact.
TEST(TrialWorld, WhatLandsOnATableStaysThere)
{
    constexpr double kDrop = 0.02;  // [m]
    for (const double mass : {0.02, 2.0})
    {
        const Pinch pinch(mass, 0.5, 0.0);
        pinch.world->addTable(Eigen::Vector3d(0.0, -0.02 - 2.0 * kMargin - kDrop, 0.0),
                              Eigen::Vector3d::UnitY());
        double fastest = 0.0;
        double back = 0.0;  // upwards
        for (int k = 0; k < 120; ++k)
        {
            pinch.run(kStep, Eigen::Vector3d(0.0, -kGravity, 0.0));
            fastest = std::max(fastest, -pinch.world->objectVelocity().y());
            back = std::max(back, pinch.world->objectVelocity().y());
        }
        EXPECT_NEAR(fastest, std::sqrt(2.0 * kGravity * kDrop), 2.0 * kGravity * kStep);
        EXPECT_LT(back, 0.01 * fastest);
        EXPECT_LT(pinch.world->objectVelocity().norm(), 1e-6);
        EXPECT_NEAR(pinch.world->objectCenter().y(), -kDrop, kMargin);
    }
}

TEST(TrialWorld, ABlockedDrivePressesByItsWholeForceHoweverSlowItIs)
{
    // The other jaw keeps its place, so this one presses by stiffness times what is left of its
    // way.
    for (const double speed : {0.001, 0.01, 0.1})
    {
        const Pinch pinch(0.2, 0.5, 0.0);
        constexpr double kStiffness = 2e3;
        const DriveSettings settings{
            .effort = 50.0, .stiffness = kStiffness, .damping = 40.0, .maxSpeed = speed};
        pinch.world->drive(2, settings, 0.025);
        pinch.settle();
        const double error = 0.025 - pinch.world->positions()[2];
        EXPECT_NEAR(0.5 * pinch.world->holdingForces().sum, kStiffness * error, 0.01);
        EXPECT_GT(error, 0.004);
    }
}

TEST(TrialWorld, AJawPressesOnWhatIsDrivenAwayFromIt)
{
    // A force that would take the cube away from one jaw within a step, were it not for the other.
    constexpr double kForce = 20.0;
    const Pinch pinch(0.05, 0.5, kForce);
    const Eigen::Vector3d away(-30.0, 0.0, 0.0);
    for (int k = 0; k < 60; ++k)
    {
        pinch.world->step(kStep, Eigen::Vector3d::Zero(), away);
    }
    EXPECT_NEAR(pinch.world->holdingForces().sum, 2.0 * kForce + away.norm(), 0.1);
    EXPECT_LT(pinch.world->ccdCounters().m_impacts, 10);
}

TEST(TrialWorld, AFreeDriveKeepsItsSpeed)
{
    const Pinch pinch(0.2, 0.5, 0.0);
    const DriveSettings settings{
        .effort = 50.0, .stiffness = 2e3, .damping = 40.0, .maxSpeed = 0.02};
    pinch.world->drive(2, settings, 0.0);
    double before = pinch.world->positions()[2];
    double fastest = 0.0;
    for (int k = 0; k < 360; ++k)
    {
        pinch.run(kStep, Eigen::Vector3d::Zero());
        const double now = pinch.world->positions()[2];
        fastest = std::max(fastest, std::abs(now - before) / kStep);
        before = now;
    }
    EXPECT_LE(fastest, 0.02 + 1e-6);
    EXPECT_GE(fastest, 0.015);
    EXPECT_NEAR(before, 0.0, 1e-4);
}

TEST(TrialWorld, ACoupledJawFollowsAndSharesTheForce)
{
    HandModel hand = tests::makeGripper(true);
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    const Eigen::Isometry3d X_WH(Eigen::Translation3d(0.0, 0.0, -0.035));
    TrialWorld world(hand, cube, {.mass = 0.2, .friction = 0.5}, X_WH, {0.0, 0.0195, 0.0195});
    world.drive(1, {.effort = 8.0, .stiffness = 1e6, .damping = 1e3, .maxSpeed = 0.1}, 0.039);
    EXPECT_THROW(world.drive(2, {}, 0.0), std::invalid_argument);
    for (int k = 0; k < 120; ++k)
    {
        world.step(kStep, Eigen::Vector3d(0.0, -kGravity, 0.0), kNoForce);
        const std::vector<double> positions = world.positions();
        EXPECT_NEAR(positions[1], positions[2], 5e-5);
    }
    // One motor of 8 N, two jaws.
    EXPECT_NEAR(world.holdingForces().sum, 8.0, 1e-2);
    EXPECT_LT(std::abs(world.objectCenter().y()), 2e-3);  // what it fell while they closed
}

TEST(TrialWorld, SameCallsSameBits)
{
    const auto run = []
    {
        const Pinch pinch(0.3, 0.5, 4.0);
        pinch.settle();
        pinch.run(0.5, Eigen::Vector3d(1.0, -kGravity, 2.0));
        return pinch.world->objectPose().matrix().eval();
    };
    EXPECT_EQ(run(), run());
}

TEST(TrialWorld, RefusesWhatHasNoMassOrNegativeFriction)
{
    EXPECT_THROW(Pinch(0.0, 0.5, 1.0), std::invalid_argument);
    EXPECT_THROW(Pinch(0.1, -0.5, 1.0), std::invalid_argument);
}

/// What Bullet asks about is compounds of one mesh, as hands and objects of trials are.
TEST(RestingDispatcher, DistancesFollowAMotionThatIsTooSmallForASearch)
{
    constexpr double kWay = 1e-5;
    btDefaultCollisionConfiguration configuration;
    RestingDispatcher dispatcher(&configuration);
    dispatcher.setRestingWay(2.0 * kWay);
    const btCcdRegistration registration(dispatcher);
    btDbvtBroadphase broadphase;
    btCollisionWorld world(&dispatcher, &broadphase, &configuration);
    const std::unique_ptr<btCcdMeshShape> mesh =
        btCcdMeshShape::fromMesh(makeBox(Eigen::Vector3d::Constant(0.02)));
    mesh->setMargin(kMargin);
    btCompoundShape shape(false, 1);
    shape.addChildShape(btTransform::getIdentity(), mesh.get());
    btCollisionObject lower;
    btCollisionObject upper;
    for (btCollisionObject* object : {&lower, &upper})
    {
        object->setCollisionShape(&shape);
        world.addCollisionObject(object);
    }
    const auto distanceAt = [&](double height)
    {
        upper.setWorldTransform(btTransform(btQuaternion::getIdentity(), {0.0, 0.0, height}));
        world.performDiscreteCollisionDetection();
        double least = 1.0;
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
        {
            const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold.getNumContacts(); ++k)
            {
                least = std::min(least, double(manifold.getContactPoint(k).getDistance()));
            }
        }
        return least;
    };
    constexpr double kTouching = 0.04 + 2.0 * kMargin;
    EXPECT_NEAR(distanceAt(kTouching), 0.0, 1e-12);
    EXPECT_NEAR(distanceAt(kTouching + kWay), kWay, 1e-12);
    EXPECT_NEAR(distanceAt(kTouching - kWay), -kWay, 1e-12);
    world.removeCollisionObject(&upper);
    world.removeCollisionObject(&lower);
}
}  // namespace
}  // namespace bullet_ccd::grasp
