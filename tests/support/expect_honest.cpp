#include "tests/support/expect_honest.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_scenes.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

using Eigen::Vector3d;

namespace
{
void expectWitnesses(const RigidScene& scene, const ToiResult& result, const std::string& what)
{
    const double rounding = roundingOf(scene);
    const Eigen::Isometry3d X_AW = oraclePose(scene.motionA, result.time).inverse();
    const Eigen::Isometry3d X_BW = oraclePose(scene.motionB, result.time).inverse();
    ASSERT_NE(result.triangleA, kNone) << what;
    ASSERT_NE(result.triangleB, kNone) << what;
    const Corners a = cornersOf(scene.meshA, static_cast<std::size_t>(result.triangleA));
    const Corners b = cornersOf(scene.meshB, static_cast<std::size_t>(result.triangleB));
    EXPECT_LE(distanceToTriangle(X_AW * result.pointA, a), rounding) << what;
    EXPECT_LE(distanceToTriangle(X_BW * result.pointB, b), rounding) << what;
    const Vector3d across = result.pointB - result.pointA;
    EXPECT_NEAR(across.norm(), result.gap, 2.0 * rounding) << what;
    EXPECT_NEAR(result.normal.norm(), 1.0, 1e-12) << what;
    // The direction of a gap is known to rounding / gap.
    EXPECT_GE(result.normal.dot(across), across.norm() - 4.0 * rounding) << what;
}
}  // namespace

void expectHonest(const RigidScene& scene,
                  const ToiResult& result,
                  double tolerance,
                  const std::string& what)
{
    const double rounding = roundingOf(scene);
    const OracleBody a = oracleBody(scene.meshA, scene.motionA);
    const OracleBody b = oracleBody(scene.meshB, scene.motionB);
    switch (result.status)
    {
        case ToiStatus::Separated:
        case ToiStatus::TouchingLeaving:
            EXPECT_EQ(result.time, 1.0) << what;
            break;
        case ToiStatus::Hit:
        case ToiStatus::TouchingPressing:
        {
            EXPECT_GE(result.time, 0.0) << what;
            EXPECT_LE(result.time, 1.0) << what;
            EXPECT_GT(result.gap, 0.0) << what;
            EXPECT_LE(result.gap, tolerance) << what;
            const double distance = oracleDistanceAt(a, b, result.time);
            EXPECT_GT(distance, 0.0) << what;
            // The named pair is one within the tolerance, not always the closest at that time.
            EXPECT_LE(distance, result.gap + rounding) << what;
            expectWitnesses(scene, result, what);
            break;
        }
        case ToiStatus::Overlapping:
            EXPECT_EQ(result.time, 0.0) << what;
            EXPECT_LE(oracleDistanceAt(a, b, 0.0), rounding) << what;
            break;
        case ToiStatus::IterationLimit:
        case ToiStatus::Stopped:
            ADD_FAILURE() << what << ": gave up";
            break;
    }
}
}  // namespace bullet_ccd::tests
