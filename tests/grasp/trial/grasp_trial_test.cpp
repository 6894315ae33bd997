#include "grasp/trial/grasp_trial.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

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
        grasp.X_WStart.translation() = Eigen::Vector3d(0.0, 0.0, -0.1);
        grasp.approach_W = Eigen::Vector3d::UnitZ();
        grasp.preshape = "open";
        grasp.positions = {0.0, 0.01995, 0.01995};
        for (const double side : {-1.0, 1.0})
        {
            for (const double y : {-0.01, 0.01})
            {
                for (const double z : {-0.005, 0.02})
                {
                    grasp.contacts.push_back({.link = side < 0.0 ? 1 : 2,
                                              .point = {0.02 * side, y, z},
                                              .normal = {-side, 0.0, 0.0},
                                              .gap = 5e-5});
                }
            }
        }
    }

    [[nodiscard]] TrialResult run(const TrialProtocol& protocol, const TrialOptions& options) const
    {
        TrialResult result = runTrial(hand, cube, grasp, protocol, options);
        EXPECT_TRUE(result.penetration.clean());
        return result;
    }
    [[nodiscard]] TrialOutcome outcome(const std::string& protocol,
                                       const SqueezeOptions& squeeze) const
    {
        return run(shippedProtocol(protocol), {.squeeze = squeeze}).outcome;
    }
};

const SqueezeOptions kThreeHundredGrams{.mass = 0.3, .friction = 0.5, .firmness = 4.0};

TEST(Squeeze, OfTwoJawsIsHalfOfTheForceEach)
{
    const SqueezeOptions& options = kThreeHundredGrams;
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

TEST(Squeeze, AMotorBearsTheEffortsOfAllJointsThatItMoves)
{
    // Each jaw may press by 8 N, so the motor of both gives 16 N.
    const PinchedCube coupled(true, 8.0);
    ASSERT_EQ(jointEfforts(coupled.hand).size(), 1U);
    EXPECT_EQ(jointEfforts(coupled.hand)[0].limit, 16.0);
    const Squeeze squeeze = squeezeOf(coupled.hand, coupled.grasp, kThreeHundredGrams);
    ASSERT_TRUE(squeeze.exists()) << squeeze.reason;
    EXPECT_NEAR(squeeze.normalForce, 16.0, 1e-3);
}

// One motor bends a finger of three joints by 1 : 1.5 : -2; the file states nothing that a finger
// has.
TEST(Squeeze, AMotorOfSeveralJointsIsTakenForOneEach)
{
    HandModel hand = tests::makeThreeFingers();
    std::vector<Link>& links = hand.robot.tree.links;
    for (Link& link : links)
    {
        link.joint.maxEffort = 1000.0;
    }
    const JointEffort alone = jointEfforts(hand).front();
    EXPECT_EQ(alone.limit, kUsualTorque);
    EXPECT_EQ(alone.stiffness, kUsualTorque / kFullEffortAngle);
    links[2].joint.mimicOf = 1;
    links[2].joint.mimicMultiplier = 1.5;
    links[3].joint.mimicOf = 1;
    links[3].joint.mimicMultiplier = -2.0;
    const JointEffort all = jointEfforts(hand).front();
    EXPECT_TRUE(all.isAssumed);
    EXPECT_EQ(all.limit, 4.5 * kUsualTorque);
    EXPECT_EQ(all.stiffness, 7.25 * kUsualTorque / kFullEffortAngle);
}

TEST(Squeeze, SaysWhyThereIsNone)
{
    PinchedCube weak(false, 1.0);
    EXPECT_EQ(squeezeOf(weak.hand, weak.grasp, {.mass = 0.5}).reason.rfind("limits", 0), 0U);
    PinchedCube oneSided(false, 50.0);
    oneSided.grasp.contacts.resize(4);
    EXPECT_EQ(squeezeOf(oneSided.hand, oneSided.grasp, {.mass = 0.5}).reason.rfind("geometry", 0),
              0U);
    oneSided.grasp.contacts.resize(1);
    EXPECT_FALSE(squeezeOf(oneSided.hand, oneSided.grasp, {.mass = 0.5}).exists());
    for (const double effort : {0.0, 1000.0, std::numeric_limits<double>::infinity()})
    {
        const PinchedCube strange(false, effort);
        EXPECT_TRUE(jointEfforts(strange.hand)[0].isAssumed);
    }
    EXPECT_THROW((void)squeezeOf(weak.hand, weak.grasp, {.mass = 0.0}), std::invalid_argument);
    EXPECT_THROW((void)squeezeOf(weak.hand, weak.grasp, {.mass = 0.5, .friction = -1.0}),
                 std::invalid_argument);
    EXPECT_THROW((void)squeezeOf(weak.hand, weak.grasp, {}), std::invalid_argument);
}

// The same contacts press against each other whatever the object weighs and the motors bear.
TEST(Squeeze, TheReasonDoesNotDependOnTheRatioOfMassToEffort)
{
    const PinchedCube cube(false, 50.0);
    PinchedCube oneSided(false, 50.0);
    oneSided.grasp.contacts.resize(4);
    int squeezes = 0;
    int limited = 0;
    for (double effort = 1e-5; effort < 2e3; effort *= 10.0)
    {
        for (double mass = 1e-5; mass < 2e4; mass *= 10.0)
        {
            const SqueezeOptions options{.mass = mass, .efforts = {effort, effort}};
            const Squeeze squeeze = squeezeOf(cube.hand, cube.grasp, options);
            squeezes += squeeze.exists() ? 1 : 0;
            limited += squeeze.reason.rfind("limits", 0) == 0 ? 1 : 0;
            // Two jaws bear twice their effort, and 1.2 times weight / friction is needed.
            EXPECT_EQ(squeeze.exists(), 2.0 * effort > 1.2 * mass * kStandardGravity / 0.5)
                << mass << " kg, " << effort << " N: " << squeeze.reason;
            EXPECT_EQ(squeezeOf(oneSided.hand, oneSided.grasp, options).reason.rfind("geometry", 0),
                      0U)
                << mass << " kg, " << effort << " N";
        }
    }
    EXPECT_GT(squeezes, 20);
    EXPECT_EQ(squeezes + limited, 90);
}

// A palm hardly gives way beside soft fingers, and answers nearly all of a load; of their forces,
// friction of 0.02 brings a 25th to it, of which it holds a 50th.
TEST(Squeeze, ThePalmBehindSoftFingersIsNoBadGeometry)
{
    PinchedCube cube(false, 50.0);
    cube.grasp.contacts.push_back(
        {.link = 0, .point = {0.0, 0.0, -0.02}, .normal = {0.0, 0.0, 1.0}, .gap = 5e-5});
    for (double effort = 1e-5; effort < 2e3; effort *= 10.0)
    {
        for (double mass = 1e-5; mass < 2e4; mass *= 10.0)
        {
            const Squeeze squeeze =
                squeezeOf(cube.hand,
                          cube.grasp,
                          {.mass = mass, .friction = 0.02, .efforts = {effort, effort}});
            EXPECT_NE(squeeze.reason.rfind("geometry", 0), 0U)
                << mass << " kg, " << effort << " N: " << squeeze.reason;
        }
    }
}

/// Files state 0, 10, 100 and 1,000 N m for fingers.
TEST(Squeeze, EffortsThatNoFingerHasAreAssumed)
{
    HandModel hand = tests::makeThreeFingers();
    const auto effortOf = [&](double stated)
    {
        hand.robot.tree.links[1].joint.maxEffort = stated;
        return jointEfforts(hand).front();
    };
    for (const double stated : {0.0, 10.0, 100.0, 1000.0})
    {
        EXPECT_EQ(effortOf(stated).limit, kUsualTorque);
        EXPECT_TRUE(effortOf(stated).isAssumed);
    }
    EXPECT_EQ(effortOf(5.0).limit, 5.0);
    EXPECT_FALSE(effortOf(5.0).isAssumed);
    // A joint that spreads a finger is one of the finger.
    hand.closingDirections[1] = 0;
    EXPECT_EQ(effortOf(30.0).limit, kUsualTorque);
    // A wrist is not: it carries all fingers.
    for (std::size_t link = 0; link < hand.robot.tree.links.size(); ++link)
    {
        if (hand.robot.tree.links[link].parent != 1)
        {
            hand.closingDirections[link] = 0;
        }
    }
    EXPECT_EQ(effortOf(30.0).limit, 30.0);
    EXPECT_FALSE(effortOf(30.0).isAssumed);
    EXPECT_EQ(effortOf(1000.0).limit, kUsualTorque);
}

TEST(GraspTrial, TwoJawsHoldACubeInAllDirections)
{
    for (const bool coupled : {false, true})
    {
        const PinchedCube pinched(coupled, 100.0);
        const TrialResult result =
            pinched.run(shippedProtocol("six"), {.squeeze = kThreeHundredGrams});
        EXPECT_EQ(result.outcome, TrialOutcome::Held);
        const double sum = 4.0 * 0.3 * kStandardGravity / 0.5;
        // What the skins give way by, a position controller presses less.
        EXPECT_NEAR(result.meanForce, sum, 0.1 * sum);
        // Jaws of a motor each press with half of it.
        ASSERT_EQ(result.meanTorques.size(), coupled ? 1U : 2U);
        for (std::size_t j = 0; j < result.meanTorques.size(); ++j)
        {
            const double expected = coupled ? sum : 0.5 * sum;
            EXPECT_NEAR(result.meanTorques[j], expected, 0.1 * expected);
            EXPECT_LE(result.meanTorques[j], result.peakTorques[j]);
        }
    }
    EXPECT_EQ(PinchedCube(false, 100.0).outcome("shake", kThreeHundredGrams), TrialOutcome::Held);
}

// Jaws that open by 2 mm or more are in the walls beside them, and nowhere a clearance away.
TEST(GraspTrial, AHandThatOpensIntoTheObjectOpensLess)
{
    PinchedCube pinched(false, 100.0);
    TriangleMesh mesh = makeBox(Eigen::Vector3d::Constant(0.02));
    for (const double side : {-1.0, 1.0})
    {
        TriangleMesh wall = makeBox({0.004, 0.02, 0.02});
        transformMesh(wall, Eigen::Affine3d(Eigen::Translation3d(0.0355 * side, 0.0, 0.0)));
        appendMesh(mesh, wall);
    }
    pinched.cube = makeGraspObject("cube between walls", std::move(mesh));
    EXPECT_EQ(pinched.outcome("six", kThreeHundredGrams), TrialOutcome::Held);
}

TEST(GraspTrial, BriefTrialsEndAsWholeOnes)
{
    const PinchedCube pinched(false, 100.0);
    TrialOptions options{.squeeze = kThreeHundredGrams};
    const TrialResult whole = pinched.run(shippedProtocol("hover"), options);
    options.brief = true;
    const TrialResult brief = pinched.run(shippedProtocol("hover"), options);
    EXPECT_EQ(whole.skipped, 0);
    EXPECT_GT(brief.skipped, brief.steps / 2);
    EXPECT_EQ(brief.outcome, whole.outcome);
    EXPECT_EQ(brief.steps, whole.steps);
    EXPECT_EQ(brief.seconds, whole.seconds);
    EXPECT_NEAR(brief.peakForce, whole.peakForce, 0.05 * whole.peakForce);
    EXPECT_NEAR(brief.slip, whole.slip, 1e-3);
    EXPECT_NEAR(brief.meanForce, whole.meanForce, 0.05 * whole.meanForce);  // it is still settling
    // What slides is not cut short, however slowly it begins.
    for (const double friction : {0.12, 0.05})
    {
        options.friction = friction;
        // It ends on the palm.
        EXPECT_EQ(pinched.run(shippedProtocol("hover"), options).outcome, TrialOutcome::Slipped);
    }
}

TEST(GraspTrial, LiftsFromATable)
{
    const PinchedCube pinched(false, 100.0);
    TrialProtocol lift = shippedProtocol("lift");
    lift.phases[1].time = 1.0;
    const TrialOptions options{.squeeze = kThreeHundredGrams, .up = Eigen::Vector3d::UnitY()};
    const TrialResult result = pinched.run(lift, options);
    EXPECT_EQ(result.outcome, TrialOutcome::Held) << result.reason;
    EXPECT_LT(result.slip, 1e-3);
    // What does not stand does not wait for the hand.
    TrialOptions leaning = options;
    leaning.up = Eigen::Vector3d(0.0, 1.0, -0.4);
    const TrialResult toppled = pinched.run(lift, leaning);
    EXPECT_EQ(toppled.outcome, TrialOutcome::NotSettled);
    EXPECT_FALSE(toppled.reason.empty());
    // Slippery as ice, it stays on the table, which sinks away from the hand.
    TrialOptions slippery = options;
    slippery.friction = 0.02;
    EXPECT_EQ(pinched.run(lift, slippery).outcome, TrialOutcome::Dropped);
}

TEST(GraspTrial, NoHandLiftsThroughTheTable)
{
    const PinchedCube pinched(false, 100.0);  // comes along +z
    const TrialOptions options{.squeeze = kThreeHundredGrams, .up = Eigen::Vector3d::UnitZ()};
    const TrialResult below = pinched.run(shippedProtocol("lift"), options);
    EXPECT_EQ(below.outcome, TrialOutcome::NeverTouched);
    EXPECT_NE(below.reason.find("table"), std::string::npos) << below.reason;
    EXPECT_EQ(pinched.run(shippedProtocol("hover"), options).outcome, TrialOutcome::Held);
}

TEST(GraspTrial, RefusesWhatIntersectsAtTheStart)
{
    PinchedCube pinched(false, 100.0);
    pinched.grasp.X_WH.translation().z() += 0.03;  // the palm is in the cube
    const TrialResult result =
        runTrial(pinched.hand, pinched.cube, pinched.grasp, shippedProtocol("hover"), {});
    EXPECT_FALSE(result.penetration.clean());
    EXPECT_EQ(result.outcome, TrialOutcome::NeverTouched);
    EXPECT_EQ(result.reason.rfind("the hand is in the object", 0), 0U) << result.reason;
}

TEST(GraspTrial, RefusesJointsBeyondTheirLimits)
{
    PinchedCube pinched(false, 100.0);
    pinched.grasp.positions[1] = 5.0;
    const std::string joint = pinched.hand.robot.tree.links[1].joint.name;
    try
    {
        (void)runTrial(pinched.hand, pinched.cube, pinched.grasp, shippedProtocol("six"), {});
        FAIL() << "accepted";
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_NE(std::string(error.what()).find(joint + " is at 5"), std::string::npos)
            << error.what();
    }
}

/// Jaws of their own motors, of which one has a much longer way: gone on until stopped, the other
/// one has pushed the cube along before it comes. As planned, they meet it where it is.
TEST(GraspTrial, ClosesAsPlannedOnWhatStandsLoosely)
{
    PinchedCube pinched(false, 100.0);
    pinched.hand.preshapes.front().positions[1] = 0.018;
    const TrialOptions options{.squeeze = kThreeHundredGrams, .up = Eigen::Vector3d::UnitY()};
    double pushed = 0.0;
    TrialOptions watched = options;
    watched.watch = [&](const TrialFrame& frame)
    {
        if (frame.stage == "close")
        {
            pushed = std::max(pushed, frame.X_WO.translation().norm());
        }
    };
    const TrialResult loose = pinched.run(shippedProtocol("lift"), watched);
    const double pushedLoosely = std::exchange(pushed, 0.0);
    watched.closesAsPlanned = true;
    const TrialResult planned = pinched.run(shippedProtocol("lift"), watched);
    EXPECT_EQ(planned.outcome, TrialOutcome::Held) << planned.reason;
    EXPECT_LT(pushed, 2e-3);
    EXPECT_GT(pushedLoosely, 4e-3) << loose.reason;
}

TEST(GraspTrial, WhoWatchesSeesTheHandLiftTheObject)
{
    const PinchedCube pinched(false, 100.0);
    TrialProtocol lift = shippedProtocol("lift");
    lift.phases[1].time = 0.25;
    TrialOptions options{.squeeze = kThreeHundredGrams, .up = Eigen::Vector3d::UnitY()};
    const TrialResult unseen = pinched.run(lift, options);
    std::vector<std::string> stages;
    std::vector<TrialFrame> frames;
    options.watch = [&](const TrialFrame& frame)
    {
        if (stages.empty() || stages.back() != frame.stage)
        {
            stages.emplace_back(frame.stage);
        }
        frames.push_back(frame);
    };
    const TrialResult seen = pinched.run(lift, options);
    EXPECT_EQ(seen.slip, unseen.slip);
    EXPECT_EQ(stages, (std::vector<std::string>{"stand", "close", "squeeze", "load"}));
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(seen.steps));
    EXPECT_FALSE(frames.front().touches);
    EXPECT_TRUE(frames.back().touches);
    EXPECT_DOUBLE_EQ(frames.back().time, seen.seconds);
    for (const auto pose : {&TrialFrame::X_WH, &TrialFrame::X_WO})
    {
        const Eigen::Vector3d way =
            (frames.back().*pose).translation() - (frames.front().*pose).translation();
        EXPECT_LT((way - 0.2 * options.up).norm(), 1e-3) << way.transpose();
    }
}

TEST(GraspTrial, TwoJawsResistAPullByTheirFriction)
{
    TrialProtocol pull{.name = "pull"};
    pull.phases.push_back({.kind = TrialPhase::Kind::Pull});
    pull.phases[0].wrench[1] = -3.0;
    for (const bool coupled : {false, true})
    {
        for (const double friction : {0.4, 0.6})
        {
            const PinchedCube pinched(coupled, 100.0);
            const TrialResult result = pinched.run(
                pull, {.squeeze = {.mass = 0.3, .friction = 0.5}, .friction = friction});
            EXPECT_EQ(result.outcome, TrialOutcome::Slipped);
            ASSERT_EQ(result.pulls.size(), 1U) << toString(result.outcome);
            for (const TrialPull& one : result.pulls)
            {
                // 2 mu N of the 2 N that press.
                EXPECT_TRUE(one.slipped);
                EXPECT_NEAR(one.share, friction, 0.03 * friction);
            }
        }
    }
}

/// Three jaws at a sphere, 120 degrees apart.
struct ThreeJaws
{
    HandModel hand;
    GraspObject sphere = makeGraspObject("sphere", makeSphere(0.02, 3));
    Grasp grasp;

    ThreeJaws()
    {
        Link palm;
        palm.name = "palm";
        hand.robot.name = "three_jaws";
        const auto add = [&](Link link, TriangleMesh mesh, int closing)
        {
            link.joint.name = link.name + "_joint";
            hand.robot.tree.links.push_back(std::move(link));
            hand.robot.linkMeshes.push_back(mesh);
            hand.trees.push_back(buildSsvTree(std::move(mesh)));
            hand.closingDirections.push_back(closing);
        };
        palm.parent = kNone;
        add(palm, makeBox(Eigen::Vector3d(0.05, 0.05, 0.005)), 0);
        grasp.X_WH.translation() = Eigen::Vector3d(0.0, 0.0, -0.06);
        grasp.positions = {0.0};
        for (int k = 0; k < 3; ++k)
        {
            const double angle = 2.0 * std::numbers::pi * k / 3.0;
            const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitZ());
            Link jaw;
            jaw.name = "jaw" + std::to_string(k);
            jaw.parent = 0;
            jaw.X_PL0 = turn * Eigen::Translation3d(0.045, 0.0, 0.06);
            jaw.joint.type = JointType::Prismatic;
            jaw.joint.axis = -Eigen::Vector3d::UnitX();
            jaw.joint.lower = 0.0;
            jaw.joint.upper = 0.03;
            jaw.joint.maxEffort = 100.0;
            add(jaw, makeBox(Eigen::Vector3d(0.005, 0.01, 0.01)), 1);
            grasp.positions.push_back(0.0195);
            const Eigen::Vector3d outwards = turn * Eigen::Vector3d::UnitX();
            grasp.contacts.push_back(
                {.link = k + 1, .point = 0.02 * outwards, .normal = -outwards, .gap = 5e-5});
        }
        for (const SsvTree& tree : hand.trees)
        {
            hand.linkTrees.push_back(&tree);
        }
    }
};

TEST(GraspTrial, ThreeFingersHoldASphereByTheirFriction)
{
    const ThreeJaws three;
    TrialProtocol pull{.name = "pull", .phases = {{.kind = TrialPhase::Kind::Pull}}};
    pull.phases[0].wrench[2] = 1.0;
    const TrialResult result = runTrial(three.hand,
                                        three.sphere,
                                        three.grasp,
                                        pull,
                                        {.squeeze = kThreeHundredGrams, .friction = 0.4});
    ASSERT_EQ(result.pulls.size(), 1U) << toString(result.outcome) << " " << result.reason;
    // 3 mu N of the 3 N that press.
    // The pads meet facets, whose normals differ a little.
    EXPECT_NEAR(result.pulls[0].share, 0.4, 0.05 * 0.4);
}

TEST(GraspTrial, SaysHowItFails)
{
    // The friction of the surfaces is a tenth of that which the squeeze counts on.
    const PinchedCube pinched(false, 100.0);
    const TrialOptions slippery{.squeeze = kThreeHundredGrams, .friction = 0.05};
    const double missing = kStandardGravity * (1.0 - 4.0 * 0.05 / 0.5);
    TrialProtocol fall{.name = "fall",
                       .phases = {{.time = 1.0, .direction = Eigen::Vector3d::UnitY()}}};
    const TrialResult dropped = pinched.run(fall, slippery);
    EXPECT_EQ(dropped.outcome, TrialOutcome::Dropped);
    EXPECT_GT(dropped.lostAt, 0.3);
    EXPECT_EQ(dropped.reason.rfind("first in phase 1, after 0.0", 0), 0U) << dropped.reason;
    const double step = 1.0 / TrialOptions{}.rate;
    const double brief = 8.0 * step;
    fall.phases[0].time = brief;
    const TrialResult slipped = pinched.run(fall, slippery);
    EXPECT_EQ(slipped.outcome, TrialOutcome::Slipped);
    const double fallen = 0.5 * missing * brief * (brief + step);
    EXPECT_NEAR(slipped.slip, fallen, 0.05 * fallen);
    // Contacts that are not there make the squeeze.
    PinchedCube far(false, 100.0);
    far.grasp.positions = {0.0, 0.0, 0.0};
    far.grasp.X_WH.translation() = Eigen::Vector3d(0.0, 0.3, 0.0);
    EXPECT_EQ(far.outcome("hover", kThreeHundredGrams), TrialOutcome::NeverTouched);
    PinchedCube weak(false, 1.0);
    EXPECT_EQ(weak.outcome("six", {.mass = 5.0}), TrialOutcome::NoSqueeze);
    weak.grasp.positions.clear();
    EXPECT_THROW((void)weak.outcome("six", {}), std::invalid_argument);
    PinchedCube nameless(false, 100.0);
    nameless.grasp.preshape = "none";
    EXPECT_THROW((void)nameless.outcome("lift", {}), std::invalid_argument);
}

TEST(GraspTrial, WhatIsSqueezedOutIsEjected)
{
    // The jaws meet a slippery sphere beyond its middle.
    PinchedCube pinched(false, 100.0);
    const GraspObject sphere = makeGraspObject("sphere", makeSphere(0.02, 4));
    pinched.grasp.X_WH.translation().y() = 0.018;
    pinched.grasp.X_WStart.translation().y() = 0.018;
    const TrialProtocol closing{.name = "closing", .start = TrialStart::Open, .phases = {{}}};
    const TrialResult result = runTrial(pinched.hand,
                                        sphere,
                                        pinched.grasp,
                                        closing,
                                        {.squeeze = kThreeHundredGrams, .friction = 0.01});
    EXPECT_EQ(result.outcome, TrialOutcome::Ejected);
    EXPECT_GT(result.lostAt, 0.0);
    EXPECT_NE(result.reason, "");
}

TEST(GraspTrial, EndsWhenTheCallerSaysSo)
{
    const PinchedCube pinched(false, 100.0);
    const std::atomic<bool> yes = true;
    const TrialResult never = pinched.run(
        shippedProtocol("hover"), {.squeeze = kThreeHundredGrams, .stop = {.isCancelled = &yes}});
    EXPECT_EQ(never.outcome, TrialOutcome::Stopped);
    EXPECT_EQ(never.steps, 0);
    // Every pull has a world of its own; one deadline ends all of them.
    TrialProtocol pulls{.name = "pulls", .phases = randomPulls(1000, 1)};
    const TrialResult some =
        pinched.run(pulls, {.squeeze = kThreeHundredGrams, .stop = stopAfter(0.3)});
    EXPECT_EQ(some.outcome, TrialOutcome::Stopped);
    EXPECT_LT(some.pulls.size(), 1000U);
    // Those that ended are what they are without a stop.
    pulls.phases.resize(std::max<std::size_t>(1, some.pulls.size()));
    const TrialResult whole = pinched.run(pulls, {.squeeze = kThreeHundredGrams});
    for (std::size_t k = 0; k < some.pulls.size(); ++k)
    {
        EXPECT_EQ(some.pulls[k].size, whole.pulls[k].size);
    }
}

TEST(GraspTrial, AHandThatIsOffStillCloses)
{
    const PinchedCube pinched(false, 100.0);
    TrialProtocol disturb = shippedProtocol("disturb");
    disturb.phases.resize(1);
    const TrialOptions options{.squeeze = kThreeHundredGrams};
    disturb.shift = 0.003;
    disturb.turn = 0.02;
    EXPECT_EQ(pinched.run(disturb, options).outcome, TrialOutcome::Held);
    disturb.shift = 0.5;
    EXPECT_EQ(pinched.run(disturb, options).outcome, TrialOutcome::NeverTouched);
}

TEST(GraspTrial, SameBitsOnAnyThreadInAnyOrder)
{
    const PinchedCube pinched(false, 100.0);
    const TrialProtocol brief{.name = "brief", .phases = {{.time = 0.2}, {.time = 0.2}}};
    const auto run = [&](double mass)
    { return pinched.run(brief, {.squeeze = {.mass = mass, .friction = 0.5}, .friction = 0.2}); };
    const TrialResult light = run(0.1);
    const TrialResult heavy = run(0.4);
    PenetrationCheck check(pinched.hand, pinched.cube);
    const auto runAgain = [&](double mass)
    {
        return pinched.run(
            brief, {.squeeze = {.mass = mass, .friction = 0.5}, .friction = 0.2, .check = &check});
    };
    const TrialResult heavyAgain = runAgain(0.4);
    const TrialResult lightAgain = runAgain(0.1);
    TrialResult heavyToo;
    TrialResult lightToo;
    std::thread first([&] { heavyToo = run(0.4); });
    std::thread second([&] { lightToo = run(0.1); });
    first.join();
    second.join();
    const auto expectSame = [](const TrialResult& a, const TrialResult& b)
    {
        EXPECT_GT(a.slip, 0.0);
        EXPECT_EQ(a.slip, b.slip);
        EXPECT_EQ(a.turn, b.turn);
        EXPECT_EQ(a.meanForce, b.meanForce);
        EXPECT_EQ(a.peakEnergy, b.peakEnergy);
        EXPECT_EQ(a.steps, b.steps);
    };
    expectSame(light, lightToo);
    expectSame(heavy, heavyToo);
    expectSame(light, lightAgain);
    expectSame(heavy, heavyAgain);
}
}  // namespace
}  // namespace bullet_ccd::grasp
