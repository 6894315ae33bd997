// What holds for every closing engine: angles at contact in closed form. The engines are named by
// the programs that have these tests.
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/grasp/closing/closing_engine.h"
#include "tests/grasp/closing/finger_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using grasp::ClosingResult;
using grasp::GraspObject;
using grasp::HandModel;

HandModel twoPhalanges()
{
    HandBuilder builder;
    const auto proximal = builder.add(0, kAtOrigin, revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    builder.add(proximal, poseOf({kL1, 0.0, 0.0}), revolute(kAxis, -1.6, 1.0), -1, finger(kL2));
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
    builder.add(0, kAtOrigin, revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    const double angle = kTouch + std::numbers::pi / 2;
    const GraspObject object = objectOf(cylinder({angle, 1.5 * std::numbers::pi}));
    const ClosingResult result = closeOnce(builder.take(), object, {0.0, kStart});
    EXPECT_EQ(result.status, ToiStatus::Hit);
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, 1);
    expectJustBefore(result.positions[1], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
}

TEST_P(ClosingEngine, ClosingOnNothingEndsAtTheLimitsExactly)  // G16
{
    HandBuilder builder;
    const auto a = builder.add(0, kAtOrigin, revolute(kAxis, 0.1, 2.0), -1, finger(kL1));
    const auto b =
        builder.add(a, poseOf({kL1, 0.0, 0.0}), revolute(kAxis, -0.7, 1.37), 1, finger(kL2));
    const auto c =
        builder.add(0, poseOf({0.0, 0.0, 1.0}), prismatic(kAxis, 0.0, 0.033), 1, finger(0.1));
    const auto still =
        builder.add(0, poseOf({0.0, 0.0, 2.0}), revolute(kAxis, -1.0, 1.0), 0, finger(0.1));
    const auto mimic =
        builder.add(0, poseOf({0.0, 0.0, 3.0}), revolute(kAxis, -9.0, 9.0), 1, finger(0.1));
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
    const auto a = builder.add(0, kAtOrigin, revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    const auto b =
        builder.add(a, poseOf({kL1, 0.0, 0.0}), revolute(kAxis, -3.0, 3.0), -1, finger(0.02));
    builder.mimic(b, a, -0.5, 0.7);
    builder.add(b, poseOf({0.02, 0.0, 0.0}), revolute(kAxis, -0.2, 1.0), -1, finger(0.02));
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
        builder.add(0, poseOf({0.0, 0.0, 1.0}), revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    const auto follower = builder.add(0, kAtOrigin, revolute(kAxis, 0.0, 2.0), -1, finger(kL1));
    builder.mimic(follower, driver, 1.0, 0.0);
    const GraspObject object = objectOf(cylinder({kTouch + std::numbers::pi / 2}));
    const ClosingResult result = closeOnce(builder.take(), object, {0.0, kStart, kStart});
    ASSERT_EQ(result.stops.size(), 1U);
    EXPECT_EQ(result.stops[0].link, follower);
    EXPECT_NEAR(result.positions[1], result.positions[2], 1e-12);
    expectJustBefore(result.positions[2], kTouch, -1.0, std::sqrt(kD * kD - kR * kR));
}
}  // namespace bullet_ccd::tests
