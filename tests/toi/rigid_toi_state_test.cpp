/// Initial and terminal states: touching, leaving, sliding, pressing, at rest, bad input.
#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/expect_honest.h"
#include "tests/support/test_parameters.h"
#include "tests/toi/cube_over_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A cube of half edge 1 at that height of its centre over the plane z = 0.
class RigidToiState : public testing::TestWithParam<ToiStrategy>
{
protected:
    [[nodiscard]] ToiResult query(const RigidScene& scene,
                                  double tolerance,
                                  double minimumSeparation = 0.0) const
    {
        return queryToi(scene,
                        {.tolerance = tolerance,
                         .minimumSeparation = minimumSeparation,
                         .strategy = GetParam()});
    }
};

INSTANTIATE_TEST_SUITE_P(Strategies, RigidToiState, kAllStrategies, nameOfStrategy);

TEST_P(RigidToiState, SurfacesThatIntersectAreOverlapping)
{
    const ToiResult result = query(cubeOverPlane(0.9, {0, 0, -1}), 1e-6);
    EXPECT_EQ(result.status, ToiStatus::Overlapping);
    EXPECT_EQ(result.time, 0.0);
    EXPECT_EQ(query(cubeOverPlane(0.9, {0, 0, 5}), 1e-6).status, ToiStatus::Overlapping);
    EXPECT_EQ(query(cubeOverPlane(0.9, {0, 0, 0}), 1e-6).status, ToiStatus::Overlapping);
}

TEST_P(RigidToiState, SurfacesThatTouchExactlyAreOverlappingHoweverTheyMove)
{
    for (const Vector3d& v : {Vector3d(0, 0, 8), Vector3d(8, 0, 0), Vector3d(0, 0, -8)})
    {
        const ToiResult result = query(cubeOverPlane(1.0, v), 1e-6);
        EXPECT_EQ(result.status, ToiStatus::Overlapping);
        EXPECT_EQ(result.time, 0.0);
    }
}

TEST_P(RigidToiState, AContactCanBeLeftSlidAlongAndSpunOn)
{
    constexpr double kTolerance = 1e-4;
    for (const double gap : {0.99e-4, 0.5e-4, 1e-6, 1e-9})
    {
        const double height = 1.0 + gap;
        for (const Vector3d& v : {Vector3d(0, 0, 8), Vector3d(8, 0, 0), Vector3d(3, -2, 0.1)})
        {
            const ToiResult result = query(cubeOverPlane(height, v), kTolerance);
            EXPECT_EQ(result.status, ToiStatus::TouchingLeaving) << gap << ", " << v.transpose();
            EXPECT_FALSE(isContact(result.status));
            EXPECT_EQ(result.time, 1.0);
            EXPECT_LE(result.gap, gap + 1e-14) << "no lower bound of the distance";
        }
        if (gap < 1e-6)
        {
            continue;  // thousands of steps while nothing comes nearer
        }
        const ToiResult spin = query(cubeOverPlane(height, {0, 0, 0}, {0, 0, 10}), kTolerance);
        EXPECT_EQ(spin.status, ToiStatus::TouchingLeaving) << gap;
    }
}

TEST_P(RigidToiState, PressingOnAContactStopsBeforeThreeQuartersOfItsGapAreLost)
{
    constexpr double kTolerance = 1e-4;
    for (const double gap : {0.9e-4, 0.5e-4, 1e-6, 1e-9})
    {
        const RigidScene scene = cubeOverPlane(1.0 + gap, {0.5, 0, -2});
        const ToiResult result = query(scene, kTolerance);
        ASSERT_EQ(result.status, ToiStatus::TouchingPressing) << gap;
        EXPECT_TRUE(isContact(result.status));
        expectHonest(scene, result, kTolerance, "pressing");
        EXPECT_LE(result.gap, 0.75 * gap);
        EXPECT_GT(result.gap, 0.0);
        EXPECT_LE(result.time, 0.5 * gap + 1e-14);
        EXPECT_GE(result.time, 0.1 * gap);
    }
}

TEST_P(RigidToiState, ClosingInALittleIsNotPressing)
{
    // To 0.9 of the gap: the distance does not shrink to zero, and not to three quarters.
    constexpr double kGap = 0.5e-4;
    const RigidScene scene = cubeOverPlane(1.0 + kGap, {0, 0, -0.1 * kGap});
    EXPECT_EQ(query(scene, 1e-4).status, ToiStatus::TouchingLeaving);
}

TEST_P(RigidToiState, OutsideOfTheToleranceIsNotTouching)
{
    const RigidScene leaving = cubeOverPlane(1.0 + 1.01e-4, {0, 0, 8});
    EXPECT_EQ(query(leaving, 1e-4).status, ToiStatus::Separated);
    const RigidScene pressing = cubeOverPlane(1.0 + 1.01e-4, {0, 0, -2});
    EXPECT_EQ(query(pressing, 1e-4).status, ToiStatus::Hit);
}

TEST_P(RigidToiState, ABodyThatLeavesAndComesBackHitsWhenItIsBack)
{
    // A rod from the origin to the wall within the tolerance; a full turn later, the pivot having
    // moved on by 1e-3, its tip goes through the wall.
    const RigidScene scene{.meshA = segment({0, 0, 0}, {0, 1, 0}),
                           .meshB = wallAtY(1.0 + 0.5e-4, 4.0),
                           .motionA = {.v_W = {0, 1e-3, 0}, .w_W = {0, 0, 2.0 * std::numbers::pi}}};
    const ToiResult result = query(scene, 1e-4);
    EXPECT_TRUE(result.status == ToiStatus::Hit || result.status == ToiStatus::TouchingPressing);
    EXPECT_GT(result.time, 0.9);
    const ToiOptions options{.tolerance = 1e-4, .strategy = GetParam()};
    const Judgement judgement = judgeToi(scene, options, result);
    EXPECT_EQ(judgement.verdict, Verdict::Right) << judgement.text();
}

TEST_P(RigidToiState, ARestartFromTheReportedContactCanGoBack)
{
    RigidScene scene = cubeOverPlane(5.0, {0, 0, -8});
    const ToiResult first = query(scene, 1e-6);
    ASSERT_EQ(first.status, ToiStatus::Hit);
    scene.motionA.X_W0 = scene.motionA.at(first.time).X_W;
    scene.motionA.v_W = {0, 0, 8};
    EXPECT_EQ(query(scene, 1e-6).status, ToiStatus::TouchingLeaving);
    scene.motionA.v_W = {5, 0, 0};
    EXPECT_EQ(query(scene, 1e-6).status, ToiStatus::TouchingLeaving);
    scene.motionA.v_W = {0, 0, -8};
    EXPECT_EQ(query(scene, 1e-6).status, ToiStatus::TouchingPressing);
}

TEST_P(RigidToiState, ManyRestartsDoNotAddUpTheirTolerances)
{
    RigidScene scene = cubeOverPlane(5.0, {0, 0, -8});
    const Vector3d end = Vector3d(0.2, 0.1, 5.0 - 8.0);
    constexpr double kTolerance = 1e-4;
    double previous = kInfinity;
    // Down to gaps that are still far above the rounding of the scene.
    for (int i = 0; previous > 1e-9; ++i)
    {
        ASSERT_LT(i, 60);
        const ToiResult result = query(scene, kTolerance);
        ASSERT_EQ(result.status, i == 0 ? ToiStatus::Hit : ToiStatus::TouchingPressing) << i;
        ASSERT_LE(result.gap, kTolerance) << i;
        ASSERT_LT(result.gap, previous) << i;
        previous = result.gap;
        scene.motionA.X_W0 = scene.motionA.at(result.time).X_W;
        scene.motionA.v_W = end - scene.motionA.X_W0.translation();
    }
    const double height = scene.motionA.X_W0.translation().z();
    EXPECT_GT(height, 1.0);
    EXPECT_LE(height, 1.0 + kTolerance);
}

TEST_P(RigidToiState, NothingMoves)
{
    const ToiResult result = query(cubeOverPlane(2.0, Vector3d::Zero()), 1e-6);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.time, 1.0);
    EXPECT_EQ(query(cubeOverPlane(1.0 + 1e-9, Vector3d::Zero()), 1e-6).status,
              ToiStatus::TouchingLeaving);
}

/// Two cubes at a gap of 1e-3 that turn and fly as one about a common hub.
RigidScene coMovingCubes(const Vector3d& hub, double turns)
{
    RigidScene scene{.meshA = cube(1.0), .meshB = cube(1.0)};
    scene.motionA.X_W0 = poseOf({0.2, 0.1, 2.001});
    for (RigidMotion* motion : {&scene.motionA, &scene.motionB})
    {
        motion->v_W = {3, -2, 1};
        motion->w_W = {0, 0, 2.0 * std::numbers::pi * turns};
        motion->reference_B = motion->X_W0.inverse() * hub;
    }
    return scene;
}

TEST_P(RigidToiState, MovingAsOneBodyIsSeparatedAndCostsNextToNothing)
{
    for (const Vector3d& hub : {Vector3d(0, 0, 0), Vector3d(0.3, -0.2, 1), Vector3d(5, 3, -4)})
    {
        for (const double turns : {0.3, 3.0, 30.0})
        {
            const ToiResult result = query(coMovingCubes(hub, turns), 1e-6);
            EXPECT_EQ(result.status, ToiStatus::Separated) << hub.transpose() << ", " << turns;
            EXPECT_LE(result.gap, 1e-3 + 1e-12);
            // In the frame of one of them nothing moves. Bounds of each body's own motion would
            // need a pose for every 1e-3 of the way: thousands.
            EXPECT_LE(result.counters.states, 128) << hub.transpose() << ", " << turns;
            EXPECT_LE(result.counters.nodePairs + result.counters.trianglePairs, 1000)
                << hub.transpose() << ", " << turns;
        }
    }
}

TEST_P(RigidToiState, RestingAndSpinningOnTheSpotCostsLittle)
{
    const ToiResult result = query(cubeOverPlane(5.0, {0, 0, 0}, {0, 0, 400}), 1e-6);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    // The spin does not bring it nearer; a bound that takes it for speed needs a pose for every
    // 1/100 of a turn.
    EXPECT_LE(result.counters.states, GetParam() == ToiStrategy::C2A ? 1024 : 64);
}

TEST_P(RigidToiState, ContactAtTheVeryEndIsFound)
{
    const RigidScene scene = cubeOverPlane(5.0, {0, 0, -4});
    for (const double tolerance : {1e-3, 1e-6, 1e-9})
    {
        const ToiResult result = query(scene, tolerance);
        ASSERT_EQ(result.status, ToiStatus::Hit) << tolerance;
        EXPECT_LE(result.time, 1.0);
        EXPECT_GE(result.time, 1.0 - tolerance / 4.0 - 1e-14);
    }
}

TEST_P(RigidToiState, ContactJustAfterTheEndIsNotReported)
{
    const RigidScene scene = cubeOverPlane(5.0, {0, 0, -4.0 * (1.0 - 1e-9)});
    const ToiResult result = query(scene, 1e-10);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.time, 1.0);
}

TEST_P(RigidToiState, ContactAtOnceIsFound)
{
    constexpr double kGap = 4e-9;
    const RigidScene scene = cubeOverPlane(1.0 + kGap, {0, 0, -4});
    for (const double tolerance : {1e-6, 1e-8, 1e-9})
    {
        const ToiResult result = query(scene, tolerance);
        ASSERT_EQ(result.status, tolerance > kGap ? ToiStatus::TouchingPressing : ToiStatus::Hit)
            << tolerance;
        EXPECT_GE(result.time, 0.0);
        EXPECT_LE(result.time, 1e-9 + 1e-15);
    }
}

TEST_P(RigidToiState, InsideAHollowBoxIsNotOverlapping)
{
    RigidScene scene{.meshA = cube(0.5), .meshB = cube(2.0), .motionA = {.v_W = {0, 0, 4}}};
    const ToiResult result = query(scene, 1e-6);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_LE(result.time, (2.0 - 0.5) / 4.0);
    EXPECT_GE(result.time, (2.0 - 0.5) / 4.0 - 1e-6 / 4.0 - 1e-14);
}

TEST_P(RigidToiState, RejectsMotionsAndTolerancesThatAreNotFinite)
{
    const RigidScene good = cubeOverPlane(5.0, {0, 0, -4});
    for (const double bad : {kNan, kInfinity, -kInfinity})
    {
        RigidScene scene = good;
        scene.motionA.v_W.y() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motionB.w_W.x() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motionA.X_W0.translation().z() = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motionB.X_W0.linear()(1, 1) = bad;
        EXPECT_THROW((void)query(scene, 1e-6), std::invalid_argument);
    }
    for (const double tolerance : {0.0, -1e-6, kNan})
    {
        EXPECT_THROW((void)query(good, tolerance), std::invalid_argument);
    }
    for (const double separation : {-1e-6, kNan, kInfinity})
    {
        EXPECT_THROW((void)query(good, 1e-6, separation), std::invalid_argument);
    }
}

std::string messageOf(const RigidBody& bodyA, const RigidBody& bodyB)
{
    ToiWorkspace work;
    try
    {
        (void)rigidToi(bodyA, bodyB, {}, work);
    }
    catch (const std::invalid_argument& error)
    {
        return error.what();
    }
    return "";
}

TEST(RigidToiInput, ABodyWithoutAHierarchyIsNamed)
{
    const SsvTree tree = buildSsvTree(cube(1.0));
    EXPECT_THAT(messageOf({.tree = &tree}, {}),
                testing::AllOf(testing::HasSubstr("body 1"), testing::HasSubstr("buildSsvTree()")));
    EXPECT_THAT(messageOf({}, {.tree = &tree}), testing::HasSubstr("body 0"));
}

TEST(RigidToiInput, PosesThatAreNoRotationAndTranslationAreNamed)
{
    const SsvTree tree = buildSsvTree(cube(1.0));
    const RigidBody other{.tree = &tree};
    Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
    mirror(0, 0) = -1.0;
    Eigen::Matrix3d singular = Eigen::Matrix3d::Identity();
    singular(2, 2) = 0.0;
    Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
    shear(0, 1) = 0.01;
    const Eigen::Matrix3d scale = 1.001 * Eigen::Matrix3d::Identity();
    for (const Eigen::Matrix3d& bad : {mirror, singular, shear, scale})
    {
        RigidBody body{.tree = &tree};
        body.motion.X_W0.translation() = Vector3d(9, 0, 0);
        body.motion.X_W0.linear() = bad;
        EXPECT_THAT(messageOf(body, other),
                    testing::AllOf(testing::HasSubstr("X_W0 of body 0"),
                                   testing::HasSubstr("no rotation and translation"),
                                   testing::HasSubstr("scale or mirror the mesh")));
        EXPECT_THAT(messageOf(other, body), testing::HasSubstr("X_W0 of body 1"));
    }
    RigidBody drifted{.tree = &tree};
    drifted.motion.X_W0.translation() = Vector3d(9, 0, 0);
    drifted.motion.X_W0.linear() *= 1.00001;
    EXPECT_EQ(messageOf(drifted, other), "");
}

TEST_P(RigidToiState, GivingUpIsSaidAndStillCertified)
{
    const RigidScene scene = cubeOverPlane(5.0, {0, 0, -8}, {1, 2, 3});
    const double exact = query(scene, 1e-9).time;
    const SsvTree treeA = buildSsvTree(scene.meshA);
    const SsvTree treeB = buildSsvTree(scene.meshB);
    ToiWorkspace work;
    int limited = 0;
    for (const std::int64_t limit : {1, 2, 5, 10, 20, 50})
    {
        const ToiResult result =
            rigidToi({&treeA, scene.motionA},
                     {&treeB, scene.motionB},
                     {.tolerance = 1e-9, .strategy = GetParam(), .maxIterations = limit},
                     work);
        EXPECT_LE(result.time, exact + 1e-9);
        limited += result.status == ToiStatus::IterationLimit ? 1 : 0;
    }
    EXPECT_GE(limited, 2);
}
}  // namespace
}  // namespace bullet_ccd::tests
