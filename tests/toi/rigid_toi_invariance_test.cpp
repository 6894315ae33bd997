/// Relations between answers that hold whatever the answer is.
#include "tests/support/random_scenes.h"
#include "tests/support/random_trees.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

namespace bullet_ccd::tests
{
namespace
{
constexpr double kTolerance = 1e-6;
constexpr int kScenes = 250;

double distanceAt(const RigidScene& scene, double t)
{
    return oracleDistanceAt(
        oracleBody(scene.meshA, scene.motionA), oracleBody(scene.meshB, scene.motionB), t);
}

/// Both times lie where the distance is between 0 and the tolerance, so they agree as far as they
/// promise to: at the later of two there was no contact before, at the earlier the gap is closed.
void expectSameContact(const RigidScene& scene,
                       const ToiResult& first,
                       const ToiResult& second,
                       const std::string& what)
{
    const double allowed = kTolerance + roundingOf(scene);
    if (first.status == second.status)
    {
        if (first.status == ToiStatus::Hit)
        {
            EXPECT_LE(distanceAt(scene, first.time), allowed) << what;
            EXPECT_LE(distanceAt(scene, second.time), allowed) << what;
            EXPECT_NEAR(first.time, second.time, 0.02) << what;
        }
        return;
    }
    // Only a near miss may be answered in both ways.
    const ToiResult& hit = first.status == ToiStatus::Hit ? first : second;
    ASSERT_EQ(hit.status, ToiStatus::Hit) << what;
    EXPECT_LE(distanceAt(scene, hit.time), allowed) << what;
}

TEST(RigidToi, SwappingTheBodiesKeepsTheTime)
{
    Random random(80);
    int same = 0;
    int hits = 0;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = queryToi(scene, kTolerance);
        const ToiResult second = queryToi(swapped(scene), kTolerance);
        expectSameContact(scene, first, second, std::to_string(i));
        hits += first.status == ToiStatus::Hit ? 1 : 0;
        same += first.status == ToiStatus::Hit && std::abs(first.time - second.time) < 1e-5 ? 1 : 0;
    }
    EXPECT_GT(hits, kScenes / 4);
    EXPECT_GT(same, hits * 95 / 100);
}

TEST(RigidToi, MovingTheWholeSceneKeepsTheTime)
{
    Random random(81);
    int hits = 0;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = queryToi(scene, kTolerance);
        const Eigen::Isometry3d X = random.pose(random.chance(0.5) ? 5.0 : 1e4);
        const RigidScene other = moved(scene, X);
        const ToiResult second = queryToi(other, kTolerance);
        expectSameContact(other, first, second, std::to_string(i));
        expectHonest(other, second, kTolerance, std::to_string(i));
        hits += first.status == ToiStatus::Hit ? 1 : 0;
    }
    EXPECT_GT(hits, kScenes / 4);
}

TEST(RigidToi, CommonVelocityKeepsTheTime)
{
    Random random(82);
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        RigidScene other = scene;
        const Eigen::Vector3d drift = random.inBox(1e3);
        other.motionA.v_W += drift;
        other.motionB.v_W += drift;
        expectSameContact(
            other, queryToi(scene, kTolerance), queryToi(other, kTolerance), std::to_string(i));
    }
}

TEST(RigidToi, OrderOfTrianglesDoesNotChangeTheTime)
{
    Random random(83);
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        RigidScene other = scene;
        other.meshA = permuted(scene.meshA, random);
        other.meshB = permuted(scene.meshB, random);
        const ToiResult first = queryToi(scene, kTolerance);
        const ToiResult second = queryToi(other, kTolerance);
        expectSameContact(scene, first, second, std::to_string(i));
        EXPECT_NEAR(first.time, second.time, 1e-5) << i;
    }
}

TEST(RigidToi, UnitOfLengthDoesNotChangeTheTime)
{
    Random random(84);
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = queryToi(scene, kTolerance);
        for (const double factor : {0x1p-20, 0x1p20, 1e-3})
        {
            RigidScene other = scene;
            other.meshA = scaled(scene.meshA, factor);
            other.meshB = scaled(scene.meshB, factor);
            for (RigidMotion* motion : {&other.motionA, &other.motionB})
            {
                motion->X_W0.translation() *= factor;
                motion->v_W *= factor;
            }
            const ToiResult second = queryToi(other, kTolerance * factor);
            EXPECT_EQ(first.status, second.status) << i;
            EXPECT_NEAR(first.time, second.time, factor == 1e-3 ? 1e-6 : 1e-12) << i;
        }
    }
}

TEST(RigidToi, RepeatingAQueryGivesTheSameBits)
{
    Random random(85);
    ToiWorkspace work;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const SsvTree treeA = buildSsvTree(scene.meshA);
        const SsvTree treeB = buildSsvTree(scene.meshB);
        const ToiOptions options{.tolerance = kTolerance};
        const ToiResult first =
            rigidToi({&treeA, scene.motionA}, {&treeB, scene.motionB}, options, work);
        const ToiResult second = queryToi(scene, kTolerance);
        EXPECT_EQ(first.status, second.status);
        EXPECT_EQ(first.time, second.time);
        EXPECT_EQ(first.triangleA, second.triangleA);
        EXPECT_EQ(first.triangleB, second.triangleB);
        EXPECT_EQ(first.counters.nodePairs, second.counters.nodePairs);
        EXPECT_EQ(first.counters.trianglePairs, second.counters.trianglePairs);
    }
}

TEST(RigidToi, SmallerTolerancesAreReachedLater)
{
    Random random(86);
    int hits = 0;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        double previous = 0.0;
        for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8})
        {
            const ToiResult result = queryToi(scene, tolerance);
            // Each answer lies between the times at which the distance falls to its tolerance and
            // to zero, so a hundredfold tolerance cannot be answered later by more than that.
            if (result.status == ToiStatus::Hit)
            {
                ++hits;
                EXPECT_GE(result.time, previous - 0.02) << i;
                EXPECT_LE(result.gap, tolerance) << i;
            }
            previous = result.time;
        }
    }
    EXPECT_GT(hits, kScenes);
}

TEST(RigidToi, ALongerHorizonKeepsTheContact)
{
    Random random(87);
    int hits = 0;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = queryToi(scene, kTolerance);
        if (first.status != ToiStatus::Hit)
        {
            continue;
        }
        ++hits;
        RigidScene longer = scene;
        for (RigidMotion* motion : {&longer.motionA, &longer.motionB})
        {
            motion->v_W *= 2.0;
            motion->w_W *= 2.0;
        }
        const ToiResult second = queryToi(longer, kTolerance);
        ASSERT_EQ(second.status, ToiStatus::Hit) << i;
        EXPECT_NEAR(2.0 * second.time, first.time, 0.02) << i;
        EXPECT_LE(distanceAt(longer, second.time), kTolerance + roundingOf(longer)) << i;
    }
    EXPECT_GT(hits, kScenes / 4);
}
}  // namespace
}  // namespace bullet_ccd::tests
