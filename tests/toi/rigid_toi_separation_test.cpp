/// Queries that must keep a clearance: closed forms, and what counts as touching.
#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/test_parameters.h"
#include "tests/toi/cube_over_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

/// A cube of half edge 1 at that height of its centre over the plane z = 0.
class RigidToiSeparation : public testing::TestWithParam<ToiStrategy>
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

INSTANTIATE_TEST_SUITE_P(Strategies, RigidToiSeparation, kAllStrategies, nameOfStrategy);

/// The answer of a query that must stop at distance s, reached at `exact` with closing speed c.
void expectStop(const RigidScene& scene,
                const ToiResult& result,
                const ToiOptions& options,
                double exact,
                double speed)
{
    const double s = options.minimumSeparation;
    ASSERT_EQ(result.status, ToiStatus::Hit) << s;
    EXPECT_LE(result.time, exact + 1e-14) << s;
    EXPECT_GE(result.time, exact - 1.1 * options.tolerance / speed - 1e-14) << s;
    EXPECT_GT(result.gap, s);
    EXPECT_LE(result.gap, s + options.tolerance);
    const Judgement judgement = judgeToi(scene, options, result);
    EXPECT_EQ(judgement.verdict, Verdict::Right) << judgement.text();
    EXPECT_NEAR((result.pointB - result.pointA).norm(), result.gap, 1e-13);
}

TEST_P(RigidToiSeparation, StopsAtTheMinimumSeparationOfSphereAndBox)
{
    // A sphere whose lowest point is a vertex falls onto a box: (5 - 0.7 - 1 - s) / 4.
    const RigidScene scene{.meshA = sphereWithPole(0.7, -Vector3d::UnitZ()),
                           .meshB = cube(1.0),
                           .motionA = {.X_W0 = poseOf({0.1, 0.2, 5}), .v_W = {0, 0, -4}}};
    for (const double s : {0.0, 1e-6, 1e-3, 0.5, 2.0})
    {
        for (const double tolerance : {1e-3, 1e-6, 1e-9})
        {
            const ToiOptions options{
                .tolerance = tolerance, .minimumSeparation = s, .strategy = GetParam()};
            expectStop(scene, queryToi(scene, options), options, (5.0 - 0.7 - 1.0 - s) / 4.0, 4.0);
        }
    }
}

TEST_P(RigidToiSeparation, StopsAtTheMinimumSeparationOfTwoSpheres)
{
    // |p + v t| = R + s, with both poles on the line of centres at that time.
    const Vector3d p(3, 1, -0.5);
    const Vector3d v(-6, -1.5, 1);
    for (const double s : {1e-3, 0.3})
    {
        const double R = 1.2 + s;
        const double pv = p.dot(v);
        const double exact =
            (-pv - std::sqrt(pv * pv - v.squaredNorm() * (p.squaredNorm() - R * R))) /
            v.squaredNorm();
        const Vector3d towardsA = (p + exact * v).normalized();
        const RigidScene scene{.meshA = sphereWithPole(0.7, -towardsA),
                               .meshB = sphereWithPole(0.5, towardsA),
                               .motionA = {.X_W0 = poseOf(p), .v_W = v}};
        const ToiOptions options{.tolerance = 1e-7, .minimumSeparation = s, .strategy = GetParam()};
        expectStop(scene, queryToi(scene, options), options, exact, -v.dot(towardsA));
    }
}

TEST_P(RigidToiSeparation, StopsARotatingRodAtTheMinimumSeparation)
{
    const double w = 0.5 * std::numbers::pi;
    const RigidScene scene{.meshA = segment({0, 0, 0}, {2, 0, 0}),
                           .meshB = wallAtY(1.0, 4.0),
                           .motionA = {.w_W = {0, 0, w}}};
    for (const double s : {1e-4, 0.1, 0.7})
    {
        const double angle = std::asin((1.0 - s) / 2.0);
        const ToiOptions options{.tolerance = 1e-6, .minimumSeparation = s, .strategy = GetParam()};
        expectStop(scene, queryToi(scene, options), options, angle / w, 2.0 * w * std::cos(angle));
    }
}

TEST_P(RigidToiSeparation, AClearanceThatIsKeptIsSeparated)
{
    const RigidScene slide = cubeOverPlane(1.01, {30, 0, 0});
    EXPECT_EQ(query(slide, 1e-5, 0.009).status, ToiStatus::Separated);
    EXPECT_LE(query(slide, 1e-5, 0.009).gap, 0.01 + 1e-14);
}

TEST_P(RigidToiSeparation, StartingWithinTheMinimumSeparationIsOverlapping)
{
    for (const double vz : {-2.0, 0.0, 2.0})
    {
        const ToiResult result = query(cubeOverPlane(1.3, {0, 0, vz}), 1e-6, 0.5);
        EXPECT_EQ(result.status, ToiStatus::Overlapping) << vz;
        EXPECT_EQ(result.time, 0.0);
        EXPECT_NEAR(result.gap, 0.3, 1e-13);
    }
}

TEST_P(RigidToiSeparation, TouchingIsMeasuredFromTheMinimumSeparation)
{
    constexpr double kSeparation = 0.5;
    constexpr double kGap = 0.5e-4;
    const double height = 1.0 + kSeparation + kGap;
    EXPECT_EQ(query(cubeOverPlane(height, {0, 0, 1}), 1e-4, kSeparation).status,
              ToiStatus::TouchingLeaving);
    EXPECT_EQ(query(cubeOverPlane(height, {1, 0, 0}), 1e-4, kSeparation).status,
              ToiStatus::TouchingLeaving);
    const RigidScene pressing = cubeOverPlane(height, {0, 0, -2});
    const ToiResult result = query(pressing, 1e-4, kSeparation);
    EXPECT_EQ(result.status, ToiStatus::TouchingPressing);
    EXPECT_GT(result.gap, kSeparation);
    EXPECT_LE(result.gap, kSeparation + 0.75 * kGap + 1e-14);
    EXPECT_LE(result.time, kGap / 2.0 + 1e-14);
}

TEST_P(RigidToiSeparation, ALargerMinimumSeparationNeverStopsLater)
{
    Random random(91);
    int hits = 0;
    for (int i = 0; i < 100; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        double previous = 1.0;
        for (const double s : {0.0, 1e-4, 1e-2, 0.1})
        {
            const ToiResult result = query(scene, 1e-7, s);
            hits += result.status == ToiStatus::Hit ? 1 : 0;
            EXPECT_LE(result.time, previous) << i << ", " << s;
            previous = result.time;
        }
    }
    EXPECT_GT(hits, 100);
}
}  // namespace
}  // namespace bullet_ccd::tests
