// What holds for closing engines that jump over nothing.
#include "benchmarks/reference/scenes/shapes.h"
#include "grasp/closing/closing.h"
#include "grasp/sim/hand_simulation.h"
#include "tests/grasp/closing/closing_engine.h"
#include "tests/grasp/closing/finger_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
using grasp::ClosingResult;
using grasp::GraspContact;
using grasp::GraspObject;
using grasp::HandModel;

const Engine kKinematic{"Kinematic", [] { return grasp::kinematicClosing(); }};
const Engine kSimulated{"Simulated", grasp::simulatedClosing()};

class ContinuousClosing : public ClosingEngine
{
};

/// Closes finger by finger, the named ones first; every link but the palm is a finger of its own.
ClosingResult closeInTurns(const grasp::MakeCloseHand& make,
                           HandModel hand,
                           const GraspObject& object,
                           const std::vector<double>& positions,
                           const std::vector<std::string>& first = {})
{
    for (std::int32_t link = 1; link < static_cast<std::int32_t>(positions.size()); ++link)
    {
        hand.fingers.push_back({.name = "finger" + std::to_string(link), .links = {link}});
    }
    return make()(
        hand,
        object,
        kAtOrigin,
        positions,
        {.tolerance = kTolerance, .order = grasp::ClosingOrder::OneByOne, .firstFingers = first});
}
}  // namespace

TEST_P(ContinuousClosing, ToleranceSetsTheGapThatIsLeft)
{
    const HandModel hand = oneFinger();
    const GraspObject object = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    for (const double tolerance : {1e-3, 1e-5, 1e-7})
    {
        const ClosingResult result = closeOnce(hand, object, {0.0, kStart}, tolerance);
        const double gap = kD * std::sin(result.positions[1]) - kR;
        EXPECT_GT(gap, 0.0);
        EXPECT_LE(gap, tolerance * 1.0001);
        if (tolerance <= kDefaultTolerance)  // else any gap within it will do
        {
            EXPECT_GE(gap, 0.4 * tolerance);
        }
    }
}

/// Jaws 0.08 m apart that run at each other meet where their speeds say.
TEST_P(ContinuousClosing, JointsCloseAtTheirOwnSpeeds)
{
    const auto jaws = []
    {
        HandBuilder builder;
        for (const double side : {-1.0, 1.0})
        {
            Joint joint = prismatic(-side * Vector3d::UnitX(), 0.0, 0.08);
            joint.name = side < 0.0 ? "left" : "right";
            builder.add(0, kAtOrigin, joint, 1, shifted(cube(0.01), {side * 0.05, 0.0, 0.0}));
        }
        builder.selfPair(1, 2);
        return builder.take();
    };
    const GraspObject object = farAway();
    const auto expectMeeting = [](const ClosingResult& result, double left)
    {
        EXPECT_NEAR(result.positions[1], left, 2.0 * kTolerance);
        EXPECT_NEAR(result.positions[1] + result.positions[2], 0.08, 2.0 * kTolerance);
    };
    HandModel hand = jaws();
    const std::vector<double> open{0.0, 0.0, 0.0};
    const auto close = [&](std::vector<std::pair<std::string, double>> speeds)
    {
        return GetParam().make()(
            hand, object, kAtOrigin, open, {.tolerance = kTolerance, .speeds = std::move(speeds)});
    };
    expectMeeting(close({}), 0.04);
    expectMeeting(close({{"right", 3.0}}), 0.02);
    // Options win over what the hand says, joint by joint.
    hand.closingSpeeds = {1.0, 3.0, 1.0};
    expectMeeting(close({}), 0.06);
    expectMeeting(close({{"left", 1.0}}), 0.04);
    // Contacts and work depend on the ratios only.
    hand.closingSpeeds.clear();
    const ClosingResult fast = close({{"right", 3.0}});
    const ClosingResult slow = close({{"left", 1e-3}, {"right", 3e-3}});
    expectMeeting(slow, 0.02);
    EXPECT_EQ(slow.steps, fast.steps);
    EXPECT_THROW(static_cast<void>(close({{"middle", 1.0}})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(close({{"left", 0.0}})), std::invalid_argument);
}

TEST_P(ContinuousClosing, IntersectionAtTheStartIsReportedAndNothingMoves)
{
    const GraspObject object = objectOf(cylinder({}));
    const ClosingResult through = closeOnce(oneFinger(), object, {0.0, 0.1});
    EXPECT_EQ(through.status, ToiStatus::Overlapping);
    EXPECT_THAT(through.positions, testing::ElementsAre(0.0, 0.1));
    EXPECT_TRUE(through.stops.empty());

    // Fingers of 0.08 m that stand 0.12 m apart cross at 0.2 rad.
    const HandModel crossed = mirroredFingers(0.08, 0.12, true);
    EXPECT_EQ(closeOnce(crossed, farAway(), {0.0, 0.2, 0.2}).status, ToiStatus::Overlapping);

    // The palm does not move, but it counts.
    HandBuilder builder;
    builder.setPalm(shifted(cube(0.02), {kD, kR, 0.0}));
    builder.add(0, kAtOrigin, revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    EXPECT_EQ(closeOnce(builder.take(), object, {0.0, kStart}).status, ToiStatus::Overlapping);
}

TEST_P(ContinuousClosing, ReturnsWhereTheObjectStoppedEachLink)
{
    // The tangent point of the cylinder, and the inner faces of two jaws.
    const GraspObject round = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    const ClosingResult finger = closeOnce(oneFinger(), round, {0.0, kStart});
    ASSERT_EQ(finger.contacts.size(), 1U);
    const GraspContact& tangent = finger.contacts[0];
    EXPECT_EQ(tangent.link, 1);
    const Vector3d out(-std::sin(kTouch), std::cos(kTouch), 0.0);  // of the cylinder, there
    const Vector3d touch = Vector3d(kD, 0.0, 0.0) + kR * out;
    EXPECT_LT((tangent.point - touch).head<2>().norm(), kRounding);
    EXPECT_LT((tangent.normal + out).norm(), 1e-4);  // the finger is short of it by the tolerance
    EXPECT_NEAR(tangent.gap, kD * std::sin(finger.positions[1]) - kR, 1e-3 * kTolerance);

    const ClosingResult jaws = closeOnce(parallelJaw(), blockAt(0.005), {0.0, 0.0, 0.0});
    ASSERT_EQ(jaws.contacts.size(), 2U);
    EXPECT_EQ(jaws.contacts[0].link, 2);  // the nearer one
    EXPECT_EQ(jaws.contacts[1].link, 1);
    for (const GraspContact& contact : jaws.contacts)
    {
        const double side = contact.link == 1 ? -1.0 : 1.0;
        EXPECT_NEAR(contact.point.x(), 0.005 + side * 0.025, kRounding);
        EXPECT_LE(contact.point.tail<2>().cwiseAbs().maxCoeff(), 0.02 + kRounding);
        EXPECT_LT((contact.normal + side * Vector3d::UnitX()).norm(), 1e-6);
        const double travel = contact.link == 1 ? 0.02 : 0.01;
        EXPECT_NEAR(contact.gap,
                    travel - jaws.positions[static_cast<std::size_t>(contact.link)],
                    kRounding);
    }
}

TEST_P(ContinuousClosing, ReturnsNoContactWhereLinksStopEachOther)
{
    const ClosingResult result =
        closeOnce(mirroredFingers(0.08, 0.12, true), farAway(), {0.0, kStart, kStart});
    EXPECT_EQ(result.stops.size(), 2U);
    EXPECT_TRUE(result.contacts.empty());
}

TEST_P(ContinuousClosing, OneByOneTheNextFingerBeginsWhenTheOneBeforeItHasStopped)
{
    // Jaw 1 needs 0.2 s to the block, jaw 2 0.1 s.
    const GraspObject block = blockAt(0.005);
    const std::vector<double> open{0.0, 0.0, 0.0};
    for (const bool secondFirst : {false, true})
    {
        const ClosingResult result = closeInTurns(
            GetParam().make,
            parallelJaw(),
            block,
            open,
            secondFirst ? std::vector<std::string>{"finger2"} : std::vector<std::string>{});
        EXPECT_EQ(result.status, ToiStatus::Hit);
        expectJustBefore(result.positions[1], 0.02, 1.0, 1.0);
        expectJustBefore(result.positions[2], 0.01, 1.0, 1.0);
        ASSERT_EQ(result.stops.size(), 2U);
        EXPECT_EQ(result.stops[0].link, secondFirst ? 2 : 1);
        EXPECT_EQ(result.stops[1].link, secondFirst ? 1 : 2);
        EXPECT_NEAR(result.stops[0].time, secondFirst ? 0.1 : 0.2, 1e-4);
        EXPECT_NEAR(result.stops[1].time, 0.3, 1e-4);
    }
}

TEST_P(ContinuousClosing, OneByOneJointsReachTheirLimitsExactlyAndGiveTheTurnOn)
{
    // Finger 1 has two joints of which the second takes longer, finger 3 begins after both.
    HandBuilder builder;
    const auto a = builder.add(0, kAtOrigin, revolute(kAxis, 1.0, 2.0), -1, finger(kL1));
    builder.add(a, poseOf({kL1, 0.0, 0.0}), revolute(kAxis, -0.7, 1.37), -1, finger(kL2));
    builder.add(0, poseOf({0.0, 0.0, 1.0}), revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    const TriangleMesh there = shifted(cylinder({kTouch + std::numbers::pi / 2}), {0.0, 0.0, 1.0});
    const ClosingResult result =
        closeInTurns(GetParam().make, builder.take(), objectOf(there), {0.0, 1.2, 0.3, kStart});
    EXPECT_EQ(result.status, ToiStatus::Hit);
    EXPECT_EQ(result.positions[1], 1.0);
    EXPECT_EQ(result.positions[2], -0.7);
    expectJustBefore(result.positions[3], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, 3);
    EXPECT_NEAR(result.stops[0].time, 1.0 + kStart - result.positions[3], kRounding);
}

TEST_P(ContinuousClosing, OneByOneAFingerThatIsRunIntoStaysWhereItIs)
{
    // Triangle of the two bases and the place where the left tip meets the right finger, at rest
    // at kStart: length^2 = gap^2 + s^2 - 2 gap s cos(kStart), s along the right finger.
    const double gap = 0.12;
    const double length = 0.115;
    const double middle = gap * std::cos(kStart);
    const double s = middle + std::sqrt(middle * middle - gap * gap + length * length);
    ASSERT_LT(s, length);
    const double meet = std::atan2(s * std::sin(kStart), gap - s * std::cos(kStart));
    const ClosingResult result = closeInTurns(
        GetParam().make, mirroredFingers(length, gap, true), farAway(), {0.0, kStart, kStart});
    EXPECT_EQ(result.status, ToiStatus::Hit);
    EXPECT_NEAR(result.positions[1], meet, 1e-4);
    EXPECT_GE(result.positions[1], meet - kRounding);
    EXPECT_EQ(result.positions[2], kStart);
    ASSERT_EQ(result.stops.size(), 2U);
    EXPECT_FALSE(result.stops[0].byObject);
    EXPECT_FALSE(result.stops[1].byObject);
}

TEST_P(ContinuousClosing, OneByOneFingersOfOneMotorCloseTogether)
{
    const auto oneMotor = []
    {
        HandBuilder builder;
        const auto driver =
            builder.add(0, poseOf({0.0, 0.0, 1.0}), revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
        const auto follower = builder.add(0, kAtOrigin, revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
        builder.mimic(follower, driver, 1.0, 0.0);
        return builder.take();
    };
    const GraspObject object = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    const std::vector<double> open{0.0, kStart, kStart};
    const ClosingResult together = closeOnce(oneMotor(), object, open);
    const ClosingResult inTurns =
        closeInTurns(GetParam().make, oneMotor(), object, open, {"finger2"});
    EXPECT_EQ(inTurns.positions, together.positions);
    EXPECT_EQ(inTurns.stops.size(), together.stops.size());
}

TEST_P(ContinuousClosing, OneByOneRejectsANameThatNoFingerHas)
{
    EXPECT_THROW(static_cast<void>(closeInTurns(
                     GetParam().make, parallelJaw(), blockAt(0.0), {0.0, 0.0, 0.0}, {"finger7"})),
                 std::invalid_argument);
}

TEST_P(ContinuousClosing, RejectsWhatIsNoPose)
{
    const HandModel hand = oneFinger();
    const GraspObject object = farAway();
    EXPECT_THROW(static_cast<void>(closeOnce(hand, object, {0.0})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(closeOnce(hand, object, {0.0, NAN})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(closeOnce(hand, object, {0.0, 1.0}, 0.0)),
                 std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Engines, ClosingEngine, testing::Values(kKinematic, kSimulated), nameOf);
INSTANTIATE_TEST_SUITE_P(Engines,
                         ContinuousClosing,
                         testing::Values(kKinematic, kSimulated),
                         nameOf);
}  // namespace bullet_ccd::tests
