#include "tests/support/random_scenes.h"

#include "tests/oracles/brute_force_distance.h"
#include "tests/support/random_trees.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace bullet_ccd::tests
{
using Eigen::Vector3d;

TriangleMesh randomMesh(Random& random)
{
    switch (random.integer(0, 4))
    {
        case 0:
            return sphereWithPole(random.uniform(0.3, 1.0), random.direction(), 4);
        case 1:
        {
            const Vector3d half = Vector3d::Constant(0.1) + 0.6 * random.inBox(1.0).cwiseAbs();
            return box(-half, half);
        }
        default:
            return soup(random, random.integer(1, 30), 0.6, random.logUniform(0.05, 0.6));
    }
}

RigidScene randomRigidScene(Random& random)
{
    RigidScene scene{.meshA = randomMesh(random), .meshB = randomMesh(random)};
    const double fastest = random.chance(0.2) ? 20.0 : 4.0;
    scene.motionA = randomRigidMotion(random, fastest);
    scene.motionB = randomRigidMotion(random, fastest);
    const Vector3d away = random.uniform(1.5, 3.5) * random.direction();
    scene.motionA.X_W0.translation() = scene.motionB.X_W0.translation() + away;
    // Roughly at each other, and past.
    scene.motionA.v_W = scene.motionB.v_W - random.uniform(0.3, 1.5) * away + random.inBox(1.3);
    return scene;
}

ToiResult queryToi(const RigidScene& scene, double tolerance)
{
    return queryToi(scene, ToiOptions{.tolerance = tolerance});
}

ToiResult queryToi(const RigidScene& scene, const ToiOptions& options)
{
    const SsvTree treeA = buildSsvTree(scene.meshA);
    const SsvTree treeB = buildSsvTree(scene.meshB);
    ToiWorkspace work;
    return rigidToi({.tree = &treeA, .motion = scene.motionA},
                    {.tree = &treeB, .motion = scene.motionB},
                    options,
                    work);
}

double roundingOf(const RigidScene& scene)
{
    const auto extent = [](const TriangleMesh& mesh, const RigidMotion& motion)
    { return radiusOf(mesh) + motion.X_W0.translation().norm() + motion.v_W.norm(); };
    return 64.0 * 1.2e-16 *
           (extent(scene.meshA, scene.motionA) + extent(scene.meshB, scene.motionB));
}

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
            ADD_FAILURE() << what << ": gave up";
            break;
    }
}
}  // namespace bullet_ccd::tests
