/// Initial and terminal states: touching, leaving, sliding, pressing, at rest, bad input.
#include "tests/support/random_scenes.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A cube of half edge 1 at that height of its centre over the plane z = 0.
RigidScene cubeOverPlane(double height, const Vector3d& v, const Vector3d& w = Vector3d::Zero())
{
    return {.meshA = cube(1.0),
            .meshB = floorAt(0.0, 100.0),
            .motionA = {.X_W0 = poseOf({0.2, 0.1, height}), .v_W = v, .w_W = w}};
}

TEST(RigidToiState, SurfacesThatIntersectAreOverlapping)
{
    const ToiResult result = queryToi(cubeOverPlane(0.9, {0, 0, -1}), 1e-6);
    EXPECT_EQ(result.status, ToiStatus::Overlapping);
    EXPECT_EQ(result.time, 0.0);
    EXPECT_EQ(queryToi(cubeOverPlane(0.9, {0, 0, 5}), 1e-6).status, ToiStatus::Overlapping);
    EXPECT_EQ(queryToi(cubeOverPlane(0.9, {0, 0, 0}), 1e-6).status, ToiStatus::Overlapping);
}

TEST(RigidToiState, SurfacesThatTouchExactlyAreOverlappingHoweverTheyMove)
{
    for (const Vector3d& v : {Vector3d(0, 0, 8), Vector3d(8, 0, 0), Vector3d(0, 0, -8)})
    {
        const ToiResult result = queryToi(cubeOverPlane(1.0, v), 1e-6);
        EXPECT_EQ(result.status, ToiStatus::Overlapping);
        EXPECT_EQ(result.time, 0.0);
    }
}

TEST(RigidToiState, AContactCanBeLeftSlidAlongAndSpunOn)
{
    constexpr double kTolerance = 1e-4;
    for (const double gap : {1e-4, 0.9e-4, 0.5e-4, 1e-6, 1e-9})
    {
        const double height = 1.0 + gap;
        for (const Vector3d& v : {Vector3d(0, 0, 8), Vector3d(8, 0, 0), Vector3d(3, -2, 0.1)})
        {
            const ToiResult result = queryToi(cubeOverPlane(height, v), kTolerance);
            EXPECT_EQ(result.status, ToiStatus::Separated) << gap << ", " << v.transpose();
            EXPECT_EQ(result.time, 1.0);
        }
        if (gap < 1e-6)
        {
            continue;  // thousands of steps while nothing comes nearer
        }
        const ToiResult spin = queryToi(cubeOverPlane(height, {0, 0, 0}, {0, 0, 10}), kTolerance);
        EXPECT_EQ(spin.status, ToiStatus::Separated) << gap;
    }
}

TEST(RigidToiState, PressingOnAContactStopsAtAboutHalfItsGap)
{
    constexpr double kTolerance = 1e-4;
    for (const double gap : {0.9e-4, 0.5e-4, 1e-6, 1e-9})
    {
        const RigidScene scene = cubeOverPlane(1.0 + gap, {0.5, 0, -2});
        const ToiResult result = queryToi(scene, kTolerance);
        ASSERT_EQ(result.status, ToiStatus::Hit) << gap;
        expectHonest(scene, result, kTolerance, "pressing");
        EXPECT_LT(result.gap, 0.75 * gap);
        EXPECT_GT(result.gap, 0.0);
        EXPECT_LE(result.time, 0.5 * gap + 1e-14);
        EXPECT_GE(result.time, 0.1 * gap);
    }
}

TEST(RigidToiState, ARestartFromTheReportedContactCanGoBack)
{
    RigidScene scene = cubeOverPlane(5.0, {0, 0, -8});
    const ToiResult first = queryToi(scene, 1e-6);
    ASSERT_EQ(first.status, ToiStatus::Hit);
    scene.motionA.X_W0 = scene.motionA.at(first.time).X_W;
    scene.motionA.v_W = {0, 0, 8};
    EXPECT_EQ(queryToi(scene, 1e-6).status, ToiStatus::Separated);
    scene.motionA.v_W = {5, 0, 0};
    EXPECT_EQ(queryToi(scene, 1e-6).status, ToiStatus::Separated);
}

TEST(RigidToiState, ManyRestartsDoNotAddUpTheirTolerances)
{
    RigidScene scene = cubeOverPlane(5.0, {0, 0, -8});
    const Vector3d end = Vector3d(0.2, 0.1, 5.0 - 8.0);
    constexpr double kTolerance = 1e-4;
    double previous = kInfinity;
    // Down to gaps that are still far above the rounding of the scene.
    for (int i = 0; previous > 1e-9; ++i)
    {
        ASSERT_LT(i, 40);
        const ToiResult result = queryToi(scene, kTolerance);
        ASSERT_EQ(result.status, ToiStatus::Hit) << i;
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

TEST(RigidToiState, NothingMoves)
{
    const ToiResult result = queryToi(cubeOverPlane(2.0, Vector3d::Zero()), 1e-6);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.time, 1.0);
    EXPECT_EQ(queryToi(cubeOverPlane(1.0 + 1e-9, Vector3d::Zero()), 1e-6).status,
              ToiStatus::Separated);
}

TEST(RigidToiState, MovingAsOneBodyIsSeparated)
{
    RigidScene scene = cubeOverPlane(1.001, {3, -2, 1}, {0, 0, 2});
    scene.meshB = cube(1.0);
    scene.motionB = {
        .X_W0 = poseOf({0.2, 0.1, 1.001 - 2.001}), .v_W = {3, -2, 1}, .w_W = {0, 0, 2}};
    EXPECT_EQ(queryToi(scene, 1e-6).status, ToiStatus::Separated);
}

TEST(RigidToiState, ContactAtTheVeryEndIsFound)
{
    const RigidScene scene = cubeOverPlane(5.0, {0, 0, -4});
    for (const double tolerance : {1e-3, 1e-6, 1e-9})
    {
        const ToiResult result = queryToi(scene, tolerance);
        ASSERT_EQ(result.status, ToiStatus::Hit) << tolerance;
        EXPECT_LE(result.time, 1.0);
        EXPECT_GE(result.time, 1.0 - tolerance / 4.0 - 1e-14);
    }
}

TEST(RigidToiState, ContactJustAfterTheEndIsNotReported)
{
    const RigidScene scene = cubeOverPlane(5.0, {0, 0, -4.0 * (1.0 - 1e-9)});
    const ToiResult result = queryToi(scene, 1e-10);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.time, 1.0);
}

TEST(RigidToiState, ContactAtOnceIsFound)
{
    constexpr double kGap = 4e-9;
    const RigidScene scene = cubeOverPlane(1.0 + kGap, {0, 0, -4});
    for (const double tolerance : {1e-6, 1e-8, 1e-9})
    {
        const ToiResult result = queryToi(scene, tolerance);
        ASSERT_EQ(result.status, ToiStatus::Hit) << tolerance;
        EXPECT_GE(result.time, 0.0);
        EXPECT_LE(result.time, 1e-9 + 1e-15);
    }
}

TEST(RigidToiState, InsideAHollowBoxIsNotOverlapping)
{
    RigidScene scene{.meshA = cube(0.5), .meshB = cube(2.0), .motionA = {.v_W = {0, 0, 4}}};
    const ToiResult result = queryToi(scene, 1e-6);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_LE(result.time, (2.0 - 0.5) / 4.0);
    EXPECT_GE(result.time, (2.0 - 0.5) / 4.0 - 1e-6 / 4.0 - 1e-14);
}

TEST(RigidToiState, RejectsMotionsAndTolerancesThatAreNotFinite)
{
    const RigidScene good = cubeOverPlane(5.0, {0, 0, -4});
    for (const double bad : {kNan, kInfinity, -kInfinity})
    {
        RigidScene scene = good;
        scene.motionA.v_W.y() = bad;
        EXPECT_THROW((void)queryToi(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motionB.w_W.x() = bad;
        EXPECT_THROW((void)queryToi(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motionA.X_W0.translation().z() = bad;
        EXPECT_THROW((void)queryToi(scene, 1e-6), std::invalid_argument);
        scene = good;
        scene.motionB.X_W0.linear()(1, 1) = bad;
        EXPECT_THROW((void)queryToi(scene, 1e-6), std::invalid_argument);
    }
    for (const double tolerance : {0.0, -1e-6, kNan})
    {
        EXPECT_THROW((void)queryToi(good, tolerance), std::invalid_argument);
    }
}

TEST(RigidToiState, GivingUpIsSaidAndStillCertified)
{
    const RigidScene scene = cubeOverPlane(5.0, {0, 0, -8}, {1, 2, 3});
    const double exact = queryToi(scene, 1e-9).time;
    const SsvTree treeA = buildSsvTree(scene.meshA);
    const SsvTree treeB = buildSsvTree(scene.meshB);
    ToiWorkspace work;
    int limited = 0;
    for (const std::int64_t limit : {1, 2, 5, 10, 20, 50})
    {
        const ToiResult result = rigidToi({&treeA, scene.motionA},
                                          {&treeB, scene.motionB},
                                          {.tolerance = 1e-9, .maxIterations = limit},
                                          work);
        EXPECT_LE(result.time, exact + 1e-9);
        limited += result.status == ToiStatus::IterationLimit ? 1 : 0;
    }
    EXPECT_GE(limited, 2);
}
}  // namespace
}  // namespace bullet_ccd::tests
