#include "benchmarks/reference/scenes/shapes.h"
#include "grasp/closing/discrete_closing.h"
#include "grasp/closing/kinematic_closing.h"
#include "grasp/sim/hand_simulation.h"
#include "tests/grasp/closing/finger_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <string>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::ClosingOptions;
using grasp::ClosingResult;
using grasp::GraspObject;
using grasp::HandModel;

const Isometry3d kIdentity = Isometry3d::Identity();
const Vector3d kZ = Vector3d::UnitZ();
constexpr double kTolerance = 1e-6;  // [m]
constexpr double kRounding = 1e-11;  // of angles and places computed along different ways

// A finger of length L hinged at the origin sweeps down to a cylinder of radius r about z at
// (D, 0); stability catalogue G12, G13.
constexpr double kL1 = 0.12;
constexpr double kL2 = 0.06;
constexpr double kD = 0.10;
constexpr double kR = 0.03;
constexpr double kStart = 1.2;
const double kTouch = std::asin(kR / kD);  // angle of the finger when it is tangent

/// Cylinder at (D, y) with vertices at the given angles as seen from its axis.
TriangleMesh cylinder(std::initializer_list<double> angles, double y = 0.0)
{
    return shifted(prism(circlePoints(kR, circleAngles(48, 0.01, angles)), -0.05, 0.05),
                   {kD, y, 0.0});
}

GraspObject objectOf(const TriangleMesh& mesh)
{
    return grasp::makeGraspObject("object", mesh);
}

GraspObject farAway()
{
    return objectOf(shifted(cube(0.01), {0.0, 0.0, 5.0}));
}

/// The baseline, with the tolerance as its gap.
grasp::CloseHand discreteEngine()
{
    return [](const HandModel& hand,
              const GraspObject& object,
              const Isometry3d& X_WH,
              const std::vector<double>& positions,
              const ClosingOptions& options)
    {
        const auto proximity = grasp::treeProximity(hand, object);
        return grasp::discreteClosing(
            *proximity,
            hand,
            X_WH,
            positions,
            {.contactGap = options.tolerance, .contactLayer = 2.0 * options.tolerance});
    };
}

struct Engine
{
    const char* name;
    grasp::MakeCloseHand make;
};

/// What holds for every engine: angles at contact in closed form.
class ClosingEngine : public testing::TestWithParam<Engine>
{
protected:
    static ClosingResult closeOnce(const HandModel& hand,
                                   const GraspObject& object,
                                   const std::vector<double>& positions,
                                   double tolerance = kTolerance)
    {
        return GetParam().make()(hand, object, kIdentity, positions, {.tolerance = tolerance});
    }
};

/// What holds for those that jump over nothing.
class ContinuousClosing : public ClosingEngine
{
};

std::string nameOf(const testing::TestParamInfo<Engine>& test)
{
    return test.param.name;
}

const Engine kKinematic{"Kinematic", [] { return grasp::kinematicClosing(); }};
const Engine kSimulated{"Simulated", grasp::simulatedClosing()};
const Engine kDiscrete{"Discrete", discreteEngine};

/// `value` is on the near side of `contact`, by what the tolerance allows at `slope` metres a
/// radian.
void expectJustBefore(double value, double contact, double sense, double slope)
{
    const double short_ = sense * (contact - value);
    EXPECT_GE(short_, -kRounding);
    EXPECT_LE(short_, kTolerance / slope * 1.01 + kRounding);
}

HandModel oneFinger(double lower = 0.0)
{
    HandBuilder builder;
    builder.add(0, kIdentity, revolute(kZ, lower, 2.0), -1, finger(kL1));
    return builder.take();
}

HandModel twoPhalanges()
{
    HandBuilder builder;
    const auto proximal = builder.add(0, kIdentity, revolute(kZ, 0.0, 2.0), -1, finger(kL1));
    builder.add(proximal, poseOf({kL1, 0.0, 0.0}), revolute(kZ, -1.6, 1.0), -1, finger(kL2));
    return builder.take();
}
}  // namespace

TEST_P(ClosingEngine, FingerWrapsCylinderAtTheTangentAngle)  // G12a
{
    const HandModel hand = oneFinger();
    const ClosingResult result =
        closeOnce(hand, objectOf(cylinder({kTouch + std::numbers::pi / 2})), {0.0, kStart});
    EXPECT_EQ(result.status, ToiStatus::Hit);
    const double slope = std::sqrt(kD * kD - kR * kR);
    expectJustBefore(result.positions[1], kTouch, -1.0, slope);
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, 1);
    EXPECT_TRUE(result.stops[0].byObject);
    EXPECT_NEAR(result.stops[0].time, kStart - result.positions[1], kRounding);  // at 1 rad/s
}

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
        EXPECT_GE(gap, 0.4 * tolerance);
    }
}

TEST_P(ClosingEngine, JointLimitBeforeContactIsReachedExactly)  // I06
{
    // Travel 0.895 rad ends 2.9e-5 m above the cylinder, travel 0.896 rad does not.
    const GraspObject object = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    const ClosingResult free = closeOnce(oneFinger(kStart - 0.895), object, {0.0, kStart});
    EXPECT_EQ(free.status, ToiStatus::Separated);
    EXPECT_EQ(free.positions[1], kStart - 0.895);
    EXPECT_TRUE(free.stops.empty());

    const ClosingResult hit = closeOnce(oneFinger(kStart - 0.896), object, {0.0, kStart});
    EXPECT_EQ(hit.status, ToiStatus::Hit);
    EXPECT_EQ(hit.stops.size(), 1U);
}

TEST_P(ClosingEngine, DistalPhalanxGoesOnAfterTheProximalOneHasStopped)  // G13, I09
{
    const double s = kL1 - std::sqrt(kD * kD - kR * kR);
    const double second = std::numbers::pi - 2.0 * std::atan(kR / s);
    const double angle = kTouch + std::numbers::pi / 2;
    const GraspObject object = objectOf(cylinder({angle, angle - 2.0 * std::atan(s / kR)}));
    const double bent = 0.9;
    const ClosingResult result = closeOnce(twoPhalanges(), object, {0.0, kStart, bent});

    EXPECT_EQ(result.status, ToiStatus::Hit);
    expectJustBefore(result.positions[1], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
    // The joint is a little off the tangent of the proximal phalanx: to second order nothing.
    EXPECT_NEAR(result.positions[2], -second, 2.0 * kTolerance / s);
    ASSERT_EQ(result.stops.size(), 2U);
    EXPECT_EQ(result.stops[0].link, 1);
    EXPECT_EQ(result.stops[1].link, 2);
    EXPECT_NEAR(result.stops[0].time, kStart - result.positions[1], kRounding);
    EXPECT_NEAR(result.stops[1].time, bent - result.positions[2], kRounding);
}

TEST_P(ClosingEngine, ProximalPhalanxStopsWhenTheDistalOneTouches)
{
    // The object is out of the proximal phalanx's reach.
    const GraspObject object = objectOf(shifted(cube(0.01), {0.16, 0.0, 0.0}));
    const ClosingResult result = closeOnce(twoPhalanges(), object, {0.0, 0.5, 0.0});
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, 2);
    // Both joints moved for the same time.
    EXPECT_NEAR(0.5 - result.positions[1], result.stops[0].time, kRounding);
    EXPECT_NEAR(0.0 - result.positions[2], result.stops[0].time, kRounding);
    EXPECT_GT(result.positions[1], 0.05);
}

namespace
{
/// Jaws with faces at x = -0.04 and x = +0.04 that move towards each other.
HandModel parallelJaw()
{
    HandBuilder builder;
    builder.add(0,
                kIdentity,
                prismatic(Vector3d::UnitX(), 0.0, 0.04),
                1,
                box({-0.05, -0.01, -0.01}, {-0.04, 0.01, 0.01}));
    builder.add(0,
                kIdentity,
                prismatic(-Vector3d::UnitX(), 0.0, 0.04),
                1,
                box({0.04, -0.01, -0.01}, {0.05, 0.01, 0.01}));
    return builder.take();
}

GraspObject blockAt(double x)
{
    return objectOf(box({x - 0.025, -0.02, -0.02}, {x + 0.025, 0.02, 0.02}));
}
}  // namespace

TEST_P(ClosingEngine, ParallelJawsTouchACentredBlockAtOnce)  // I02
{
    const ClosingResult result = closeOnce(parallelJaw(), blockAt(0.0), {0.0, 0.0, 0.0});
    ASSERT_EQ(result.stops.size(), 2U);
    EXPECT_THAT((std::vector{result.stops[0].link, result.stops[1].link}),
                testing::UnorderedElementsAre(1, 2));
    // At once, but each as near as the tolerance asks for.
    EXPECT_NEAR(result.stops[0].time, result.stops[1].time, kTolerance / 0.1);
    expectJustBefore(result.positions[1], 0.015, 1.0, 1.0);
    expectJustBefore(result.positions[2], 0.015, 1.0, 1.0);
    EXPECT_NEAR(result.stops[1].time,
                result.positions[static_cast<std::size_t>(result.stops[1].link)] / 0.1,
                kRounding);
}

TEST_P(ClosingEngine, OneJawWaitsForTheOtherAtAnOffCentreBlock)  // I03
{
    const ClosingResult result = closeOnce(parallelJaw(), blockAt(0.005), {0.0, 0.0, 0.0});
    ASSERT_EQ(result.stops.size(), 2U);
    EXPECT_EQ(result.stops[0].link, 2);
    EXPECT_EQ(result.stops[1].link, 1);
    expectJustBefore(result.positions[2], 0.01, 1.0, 1.0);
    expectJustBefore(result.positions[1], 0.02, 1.0, 1.0);
    EXPECT_NEAR(result.stops[0].time, 0.1, 1e-4);
    EXPECT_NEAR(result.stops[1].time, 0.2, 1e-4);
}

namespace
{
/// Two fingers of length L at (+-gap/2, 0) that swing towards each other, mirrored about x = 0.
HandModel mirroredFingers(double length, double gap, bool paired)
{
    HandBuilder builder;
    const auto left =
        builder.add(0, poseOf({-gap / 2, 0.0, 0.0}), revolute(kZ, 0.0, 2.0), -1, finger(length));
    const Isometry3d turned = poseOf({gap / 2, 0.0, 0.0}, std::numbers::pi, Vector3d::UnitY());
    const auto right = builder.add(0, turned, revolute(kZ, 0.0, 2.0), -1, finger(length));
    if (paired)
    {
        builder.selfPair(left, right);
    }
    return builder.take();
}
}  // namespace

TEST_P(ClosingEngine, MirroredFingersStopTogether)  // G15
{
    // The two cylinders are mirror images; each finger meets its own.
    const double angle = kTouch + std::numbers::pi / 2;
    const double gap = 4.0 * kD;
    const TriangleMesh one = shifted(cylinder({angle}), {-gap / 2, 0.0, 0.0});
    TriangleMesh other = one;
    transformMesh(other, Eigen::Affine3d(Eigen::Scaling(-1.0, 1.0, 1.0)));
    const ClosingResult result = closeOnce(
        mirroredFingers(kL1, gap, false), objectOf(merged({one, other})), {0.0, kStart, kStart});
    ASSERT_EQ(result.stops.size(), 2U);
    EXPECT_NEAR(result.stops[0].time, result.stops[1].time, kTolerance / kL1);
    EXPECT_NEAR(result.positions[1], result.positions[2], kTolerance / kL1);
    const double slope = std::sqrt(kD * kD - kR * kR);
    expectJustBefore(result.positions[1], kTouch, -1.0, slope);
    expectJustBefore(result.positions[2], kTouch, -1.0, slope);
}

TEST_P(ClosingEngine, FingersStopEachOtherIfTheyArePaired)  // I08
{
    const double gap = 0.12;
    const double length = 0.08;
    const double meet = std::acos(gap / (2.0 * length));
    const GraspObject object = farAway();
    const ClosingResult result =
        closeOnce(mirroredFingers(length, gap, true), object, {0.0, kStart, kStart});
    EXPECT_EQ(result.status, ToiStatus::Hit);
    ASSERT_EQ(result.stops.size(), 2U);
    EXPECT_FALSE(result.stops[0].byObject);
    EXPECT_EQ(result.stops[0].time, result.stops[1].time);
    EXPECT_EQ(result.positions[1], result.positions[2]);
    expectJustBefore(result.positions[1], meet, -1.0, 2.0 * length * std::sin(meet));

    const ClosingResult unpaired =
        closeOnce(mirroredFingers(length, gap, false), object, {0.0, kStart, kStart});
    EXPECT_EQ(unpaired.status, ToiStatus::Separated);
    EXPECT_THAT(unpaired.positions, testing::ElementsAre(0.0, 0.0, 0.0));
}

TEST_P(ClosingEngine, FingersCloseAlthoughThePalmTouches)  // I07
{
    HandBuilder builder;
    builder.setPalm(box({0.05, -0.06, -0.02}, {0.15, -kR - 1e-7, 0.02}));
    builder.add(0, kIdentity, revolute(kZ, 0.0, 2.0), -1, finger(kL1));
    const double angle = kTouch + std::numbers::pi / 2;
    const GraspObject object = objectOf(cylinder({angle, 1.5 * std::numbers::pi}));
    const ClosingResult result = closeOnce(builder.take(), object, {0.0, kStart});
    EXPECT_EQ(result.status, ToiStatus::Hit);
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, 1);
    expectJustBefore(result.positions[1], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
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
    builder.add(0, kIdentity, revolute(kZ, 0.0, 2.0), -1, finger(kL1));
    EXPECT_EQ(closeOnce(builder.take(), object, {0.0, kStart}).status, ToiStatus::Overlapping);
}

TEST_P(ClosingEngine, ClosingOnNothingEndsAtTheLimitsExactly)  // G16
{
    HandBuilder builder;
    const auto a = builder.add(0, kIdentity, revolute(kZ, 0.1, 2.0), -1, finger(kL1));
    const auto b =
        builder.add(a, poseOf({kL1, 0.0, 0.0}), revolute(kZ, -0.7, 1.37), 1, finger(kL2));
    const auto c =
        builder.add(0, poseOf({0.0, 0.0, 1.0}), prismatic(kZ, 0.0, 0.033), 1, finger(0.1));
    const auto still =
        builder.add(0, poseOf({0.0, 0.0, 2.0}), revolute(kZ, -1.0, 1.0), 0, finger(0.1));
    const auto mimic =
        builder.add(0, poseOf({0.0, 0.0, 3.0}), revolute(kZ, -9.0, 9.0), 1, finger(0.1));
    builder.mimic(mimic, b, -0.3, 0.25);
    const HandModel hand = builder.take();
    const std::vector<double> open{0.0, 1.9, -0.31, 0.001, 0.4, 0.0};
    const ClosingResult result = closeOnce(hand, farAway(), open);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.positions, grasp::closedPositions(hand, open));
    EXPECT_EQ(result.positions[static_cast<std::size_t>(a)], 0.1);
    EXPECT_EQ(result.positions[static_cast<std::size_t>(c)], 0.033);
    EXPECT_EQ(result.positions[static_cast<std::size_t>(still)], 0.4);
}

TEST_P(ClosingEngine, CoupledJointsKeepTheirRatioAndStopTogether)
{
    // The second phalanx follows the first; the third is free. The first touches.
    HandBuilder builder;
    const auto a = builder.add(0, kIdentity, revolute(kZ, 0.0, 2.0), -1, finger(kL1));
    const auto b =
        builder.add(a, poseOf({kL1, 0.0, 0.0}), revolute(kZ, -3.0, 3.0), -1, finger(0.02));
    builder.mimic(b, a, -0.5, 0.7);
    builder.add(b, poseOf({0.02, 0.0, 0.0}), revolute(kZ, -0.2, 1.0), -1, finger(0.02));
    const GraspObject object = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    // What the caller says of the mimic joint does not count.
    const ClosingResult result = closeOnce(builder.take(), object, {0.0, kStart, 9.0, 0.9});
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, a);
    expectJustBefore(result.positions[1], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
    EXPECT_NEAR(result.positions[2], -0.5 * result.positions[1] + 0.7, 1e-12);
    EXPECT_EQ(result.positions[3], -0.2);  // went on to its limit
}

TEST_P(ClosingEngine, AContactOfTheFollowerStopsTheJointItFollows)
{
    // Two fingers with one motor: the follower meets the object, the other one meets nothing.
    HandBuilder builder;
    const auto driver =
        builder.add(0, poseOf({0.0, 0.0, 1.0}), revolute(kZ, 0.0, 2.0), -1, finger(kL1));
    const auto follower = builder.add(0, kIdentity, revolute(kZ, 0.0, 2.0), -1, finger(kL1));
    builder.mimic(follower, driver, 1.0, 0.0);
    const GraspObject object = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    const ClosingResult result = closeOnce(builder.take(), object, {0.0, kStart, kStart});
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, follower);
    EXPECT_NEAR(result.positions[1], result.positions[2], 1e-12);
    expectJustBefore(result.positions[2], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
}

namespace
{
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
        kIdentity,
        positions,
        {.tolerance = kTolerance, .order = grasp::ClosingOrder::OneByOne, .firstFingers = first});
}
}  // namespace

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
    const auto a = builder.add(0, kIdentity, revolute(kZ, 1.0, 2.0), -1, finger(kL1));
    builder.add(a, poseOf({kL1, 0.0, 0.0}), revolute(kZ, -0.7, 1.37), -1, finger(kL2));
    builder.add(0, poseOf({0.0, 0.0, 1.0}), revolute(kZ, 0.0, 2.0), -1, finger(kL1));
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
            builder.add(0, poseOf({0.0, 0.0, 1.0}), revolute(kZ, 0.0, 2.0), -1, finger(kL1));
        const auto follower = builder.add(0, kIdentity, revolute(kZ, 0.0, 2.0), -1, finger(kL1));
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

INSTANTIATE_TEST_SUITE_P(Engines,
                         ClosingEngine,
                         testing::Values(kKinematic, kSimulated, kDiscrete),
                         nameOf);
INSTANTIATE_TEST_SUITE_P(Engines,
                         ContinuousClosing,
                         testing::Values(kKinematic, kSimulated),
                         nameOf);
}  // namespace bullet_ccd::tests
