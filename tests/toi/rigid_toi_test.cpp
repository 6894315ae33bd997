/// rigidToi on random scenes, each answer proved by brute force: never late, never a miss, never a
/// false hit.
#include "bullet_ccd/toi/rigid_toi.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/expect_honest.h"
#include "tests/support/flat_plate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
struct Tally
{
    int hits = 0;
    int overlapping = 0;
    int separated = 0;

    void count(const ToiResult& result)
    {
        hits += result.status == ToiStatus::Hit ? 1 : 0;
        overlapping += result.status == ToiStatus::Overlapping ? 1 : 0;
        separated += result.status == ToiStatus::Separated ? 1 : 0;
    }
};

/// The whole contract for one query.
void expectAgreement(const RigidScene& scene,
                     const ToiResult& result,
                     double tolerance,
                     const std::string& what)
{
    expectHonest(scene, result, tolerance, what);
    const Judgement judgement = judgeToi(scene, {.tolerance = tolerance}, result);
    EXPECT_EQ(judgement.verdict, Verdict::Right) << what << ": " << judgement.text();
}

TEST(RigidToi, IsProvedRightOnRandomScenes)
{
    Random random(70);
    Tally tally;
    constexpr int kScenes = 2000;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const double tolerance = random.logUniform(1e-8, 1e-3);
        const ToiResult result = queryToi(scene, tolerance);
        tally.count(result);
        expectAgreement(scene, result, tolerance, "scene " + std::to_string(i));
        if (HasFatalFailure())
        {
            return;
        }
    }
    EXPECT_GT(tally.hits, kScenes * 3 / 10);
    EXPECT_LT(tally.hits, kScenes * 7 / 10);
    EXPECT_GT(tally.separated, kScenes * 2 / 10);
}

TEST(RigidToi, IsProvedRightFromOverlappingAndCloseStarts)
{
    Random random(71);
    Tally tally;
    constexpr int kScenes = 400;
    for (int i = 0; i < kScenes; ++i)
    {
        RigidScene scene = randomRigidScene(random);
        scene.motionA.X_W0.translation() =
            scene.motionB.X_W0.translation() + random.uniform(0.3, 1.6) * random.direction();
        const ToiResult result = queryToi(scene, 1e-6);
        tally.count(result);
        expectAgreement(scene, result, 1e-6, "scene " + std::to_string(i));
    }
    EXPECT_GT(tally.overlapping, kScenes / 10);
    EXPECT_GT(tally.hits, kScenes / 10);
}

TEST(RigidToi, FindsNearlyGrazingContactsOfSpinningBodies)
{
    // The obstacle is a plane at the highest point that the body reaches, or just above: the
    // tangent family of inverse-designed scenes, where most steps are small.
    Random random(72);
    Tally tally;
    constexpr int kScenes = 250;
    for (int i = 0; i < kScenes; ++i)
    {
        RigidScene scene{.meshA = soup(random, random.integer(1, 5), 0.6, 0.4),
                         .motionA = randomRigidMotion(random, 5.0)};
        double highest = -1e9;
        double start = -1e9;
        for (int k = 0; k <= 4000; ++k)
        {
            const Eigen::Isometry3d X = oraclePose(scene.motionA, k / 4000.0);
            for (const Eigen::Vector3d& v : scene.meshA.vertices)
            {
                highest = std::max(highest, (X * v).z());
            }
            start = k == 0 ? highest : start;
        }
        const double sign = random.chance(0.5) ? 1.0 : -1.0;
        const double height = highest + sign * random.logUniform(1e-7, 1e-3);
        if (height - start < 1e-3)
        {
            continue;
        }
        scene.meshB = floorAt(height, 40.0);
        const ToiResult result = queryToi(scene, 1e-7);
        tally.count(result);
        expectAgreement(scene, result, 1e-7, "scene " + std::to_string(i));
    }
    EXPECT_GT(tally.hits, 60);
    EXPECT_GT(tally.separated, 40);
}

TEST(RigidToi, IsSeparatedUpToJustBeforeTheContact)
{
    Random random(73);
    int rerun = 0;
    for (int i = 0; i < 600; ++i)
    {
        RigidScene scene = randomRigidScene(random);
        const double tolerance = 1e-7;
        const ToiResult result = queryToi(scene, tolerance);
        if (result.status != ToiStatus::Hit)
        {
            continue;
        }
        ++rerun;
        for (RigidMotion* motion : {&scene.motionA, &scene.motionB})
        {
            motion->v_W *= 0.99 * result.time;
            motion->w_W *= 0.99 * result.time;
        }
        const ToiResult shorter = queryToi(scene, tolerance);
        // A grazing approach may be within the tolerance already.
        const bool near = oracleDistanceAt(oracleBody(scene.meshA, scene.motionA),
                                           oracleBody(scene.meshB, scene.motionB),
                                           1.0) < 2.0 * tolerance;
        EXPECT_TRUE(near || shorter.status == ToiStatus::Separated) << i;
    }
    EXPECT_GT(rerun, 200);
}

/// A sphere spins in a shell that is 1 % larger: all pairs stay near all the time, so that too many
/// wait for a queue. It touches when it has moved by the clearance.
TEST(RigidToi, OfASphereThatSpinsInAShellIsThatOfTheClearance)
{
    constexpr double kClearance = 0.01;
    constexpr double kFlattening = 2e-3;  // of the faces, more than enough for this many
    const SsvTree inner = buildSsvTree(makeSphere(1.0, 4));
    const SsvTree outer = buildSsvTree(makeSphere(1.0 + kClearance, 4));
    const RigidBody shell{.tree = &outer};
    ToiWorkspace work;
    for (const ToiStrategy strategy : {ToiStrategy::BestFirst, ToiStrategy::Interval})
    {
        RigidBody sphere{.tree = &inner, .motion = {.w_W = {1.0, 2.0, 0.5}}};
        const ToiResult free = rigidToi(sphere, shell, {.strategy = strategy}, work);
        EXPECT_EQ(free.status, ToiStatus::Separated);
        EXPECT_LE(free.gap, kClearance);
        EXPECT_GT(free.counters.nodePairs, 100'000);

        sphere.motion.v_W = {0.0, 2.0 * kClearance, 0.0};
        const ToiResult hit = rigidToi(sphere, shell, {.strategy = strategy}, work);
        EXPECT_EQ(hit.status, ToiStatus::Hit);
        EXPECT_LT(hit.time, 0.5 * (1.0 + kFlattening / kClearance));
        EXPECT_GT(hit.time, 0.5 * (1.0 - kFlattening / kClearance));
        EXPECT_LE(hit.gap, kDefaultTolerance);
        EXPECT_NEAR((hit.pointB - hit.pointA).norm(), hit.gap, 1e-12);
    }
}

/// Of a plate of 28,800 triangles above another.
class RigidToiOfFlatPlates : public testing::Test
{
protected:
    /// @param v,w velocities in the frame of the lower plate
    ToiResult query(const PlateAbovePlate& scene,
                    const Eigen::Vector3d& v,
                    const Eigen::Vector3d& w)
    {
        RigidBody upper{.tree = &m_a};
        upper.motion = restAt(scene.X_WB * scene.X_BA);
        upper.motion.v_W = scene.X_WB.linear() * v;
        upper.motion.w_W = scene.X_WB.linear() * w;
        const ToiResult result = rigidToi(
            upper, {.tree = &m_b, .motion = restAt(scene.X_WB)}, {.tolerance = kTolerance}, m_work);
        m_most = std::max(m_most, result.counters.nodePairs + result.counters.trianglePairs);
        return result;
    }

    static constexpr double kTolerance = 2e-5;
    Random m_random{74};
    SsvTree m_a = buildSsvTree(flatPlate(120, 1.0));
    SsvTree m_b = buildSsvTree(flatPlate(120, 3.0));
    ToiWorkspace m_work;
    std::int64_t m_most = 0;
};

TEST_F(RigidToiOfFlatPlates, IsThatOfTheLowestCornerWhereAllTie)
{
    for (int i = 0; i < 60; ++i)
    {
        const double gap = m_random.logUniform(1e-4, 1.0);
        const double tilt = m_random.chance(0.6) ? 0.0 : m_random.logUniform(1e-12, 1e-2);
        const PlateAbovePlate scene(m_random, gap, tilt);
        const ToiResult hit = query(scene, {0.0, 0.0, -2.0 * gap}, Eigen::Vector3d::Zero());
        ASSERT_EQ(hit.status, ToiStatus::Hit) << i;
        EXPECT_LE(hit.time, 0.5 + 1e-12) << i;
        EXPECT_GE(hit.time, 0.5 * (1.0 - 1e-3 * kTolerance / gap)) << i;
        // Of the named triangles, which need not be those of the lowest corner.
        EXPECT_GE(hit.gap, gap * (1.0 - 2.0 * hit.time) - 1e-12) << i;
        EXPECT_LE(hit.gap, 2.0 * ToiOptions{}.aim * kTolerance) << i;
    }
    EXPECT_LT(m_most, 5000);
}

TEST_F(RigidToiOfFlatPlates, SlideAndTurnAtAnyGap)
{
    int touching = 0;
    for (int i = 0; i < 60; ++i)
    {
        const double gap = m_random.logUniform(1e-7, 1e-2);
        const PlateAbovePlate scene(m_random, gap, 0.0);
        const ToiResult result = query(
            scene, 0.5 * m_random.uniform(-1.0, 1.0) * Eigen::Vector3d::UnitX(), {0.0, 0.0, 0.7});
        const bool touches = gap <= kTolerance;
        touching += touches ? 1 : 0;
        EXPECT_EQ(result.status, touches ? ToiStatus::TouchingLeaving : ToiStatus::Separated)
            << i << ": gap " << gap;
        EXPECT_LE(result.gap, gap) << i;
    }
    EXPECT_GT(touching, 10);
    EXPECT_LT(touching, 50);
    EXPECT_LT(m_most, 20000);
}

TEST_F(RigidToiOfFlatPlates, ArePressedFromAnyGapWithinTheTolerance)
{
    for (int i = 0; i < 30; ++i)
    {
        const double gap = m_random.logUniform(1e-7, 0.9 * kTolerance);
        const PlateAbovePlate scene(m_random, gap, 0.0);
        const ToiResult hit = query(scene, {0.1, 0.0, -2.0 * gap}, Eigen::Vector3d::Zero());
        EXPECT_EQ(hit.status, ToiStatus::TouchingPressing) << i << ": gap " << gap;
        EXPECT_LE(hit.time, 0.5 + 1e-9) << i;
        EXPECT_GE(hit.time, 0.49) << i;
    }
    EXPECT_LT(m_most, 5000);
}

/// Its cap is flat, its wall is round: volumes of the wall do not show that it is above the plate.
TEST_F(RigidToiOfFlatPlates, ACylinderSlidesAndTurnsOnOneAtAnyGap)
{
    std::vector<Eigen::Vector2d> ring;
    constexpr int kAround = 72;
    for (int i = 0; i < kAround; ++i)
    {
        const double angle = 2.0 * std::numbers::pi * i / kAround;
        ring.emplace_back(0.4 * std::cos(angle), 0.4 * std::sin(angle));
    }
    TriangleMesh mesh;
    constexpr int kSlices = 30;
    for (int i = 0; i < kSlices; ++i)
    {
        const TriangleMesh slice = prism(ring, 1.0 * i / kSlices, (1.0 + i) / kSlices);
        mesh = merged({mesh, slice});
    }
    m_a = buildSsvTree(mesh);
    for (int i = 0; i < 30; ++i)
    {
        const double gap = m_random.logUniform(1e-7, 1e-2);
        PlateAbovePlate scene(m_random, gap, 0.0);
        const bool falls = i % 3 == 0;
        const Eigen::Vector3d v(0.4, 0.0, falls ? -2.0 * gap : 0.0);
        const ToiResult result = query(scene, v, {0.0, 0.0, falls ? 0.0 : 2.0});
        const bool touches = gap <= kTolerance;
        if (falls)
        {
            EXPECT_EQ(result.status, touches ? ToiStatus::TouchingPressing : ToiStatus::Hit) << i;
            EXPECT_LE(result.time, 0.5 + 1e-9) << i;
            EXPECT_GE(result.time, 0.49) << i;
        }
        else
        {
            EXPECT_EQ(result.status, touches ? ToiStatus::TouchingLeaving : ToiStatus::Separated)
                << i << ": gap " << gap;
        }
    }
    EXPECT_LT(m_most, 20000);
}

/// Both plates turn, about an axis in their plane, and the upper one drifts straight on in W: seen
/// from the lower one, it comes up or down by s t sin(w t). No direction that rests in W separates
/// them for long.
TEST_F(RigidToiOfFlatPlates, OnATurningPlateAreLeftAndMetWhenTheyAre)
{
    constexpr double kSpeed = 0.3;
    constexpr double kTurn = 0.1;
    for (int i = 0; i < 40; ++i)
    {
        const double gap = m_random.logUniform(1e-8, 1e-2);
        const PlateAbovePlate scene(m_random, gap, 0.0);
        const bool falls = i % 2 == 0;
        const double slide = falls ? -kSpeed : kSpeed;
        RigidBody upper{.tree = &m_a, .motion = restAt(scene.X_WB * scene.X_BA)};
        upper.motion.reference_B = scene.X_BA.inverse() * Eigen::Vector3d::Zero();
        RigidBody lower{.tree = &m_b, .motion = restAt(scene.X_WB)};
        upper.motion.w_W = lower.motion.w_W = scene.X_WB.linear() * Eigen::Vector3d(0, kTurn, 0);
        upper.motion.v_W = scene.X_WB.linear() * Eigen::Vector3d(slide, 0, 0);
        const ToiResult result = rigidToi(upper, lower, {.tolerance = kTolerance}, m_work);
        m_most = std::max(m_most, result.counters.nodePairs + result.counters.trianglePairs);
        const auto heightAt = [&](double t) { return gap + slide * t * std::sin(kTurn * t); };
        if (!falls)
        {
            EXPECT_EQ(result.status,
                      gap <= kTolerance ? ToiStatus::TouchingLeaving : ToiStatus::Separated)
                << i << ": gap " << gap;
            continue;
        }
        ASSERT_TRUE(isContact(result.status)) << i << ": gap " << gap;
        EXPECT_GE(heightAt(result.time), -1e-13) << i;
        EXPECT_LE(heightAt(result.time), 2.0 * ToiOptions{}.aim * kTolerance) << i;
    }
    EXPECT_LT(m_most, 20'000);
}
}  // namespace
}  // namespace bullet_ccd::tests
