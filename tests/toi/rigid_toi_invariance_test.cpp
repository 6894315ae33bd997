/// Relations between answers that hold whatever the answer is.
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/expect_honest.h"
#include "tests/support/test_parameters.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kSearchTolerance = 1e-6;
constexpr int kInvariantScenes = 250;

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
    const double allowed = kSearchTolerance + roundingOf(scene);
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

class RigidToiInvariance : public testing::TestWithParam<ToiStrategy>
{
protected:
    [[nodiscard]] ToiResult query(const RigidScene& scene,
                                  double tolerance = kSearchTolerance) const
    {
        return queryToi(scene, {.tolerance = tolerance, .strategy = GetParam()});
    }
};

INSTANTIATE_TEST_SUITE_P(Strategies, RigidToiInvariance, kAllStrategies, nameOfStrategy);

TEST_P(RigidToiInvariance, SwappingTheBodiesKeepsTheTime)
{
    Random random(80);
    int same = 0;
    int hits = 0;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = query(scene);
        const ToiResult second = query(swapped(scene));
        expectSameContact(scene, first, second, std::to_string(i));
        hits += first.status == ToiStatus::Hit ? 1 : 0;
        same += first.status == ToiStatus::Hit && std::abs(first.time - second.time) < 1e-5 ? 1 : 0;
    }
    EXPECT_GT(hits, kInvariantScenes / 4);
    EXPECT_GT(same, hits * 95 / 100);
}

TEST_P(RigidToiInvariance, MovingTheWholeSceneKeepsTheTime)
{
    Random random(81);
    int hits = 0;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = query(scene);
        const Eigen::Isometry3d X = random.pose(random.chance(0.5) ? 5.0 : 1e4);
        const RigidScene other = moved(scene, X);
        const ToiResult second = query(other);
        expectSameContact(other, first, second, std::to_string(i));
        expectHonest(other, second, kSearchTolerance, std::to_string(i));
        hits += first.status == ToiStatus::Hit ? 1 : 0;
    }
    EXPECT_GT(hits, kInvariantScenes / 4);
}

TEST_P(RigidToiInvariance, CommonVelocityKeepsTheTime)
{
    Random random(82);
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        RigidScene other = scene;
        const Eigen::Vector3d drift = random.inBox(1e3);
        other.motionA.v_W += drift;
        other.motionB.v_W += drift;
        expectSameContact(other, query(scene), query(other), std::to_string(i));
    }
}

TEST_P(RigidToiInvariance, OrderOfTrianglesDoesNotChangeABit)
{
    Random random(83);
    int hits = 0;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        RigidScene other = scene;
        other.meshA = permuted(scene.meshA, random);
        other.meshB = permuted(scene.meshB, random);
        const ToiResult first = query(scene);
        const ToiResult second = query(other);
        EXPECT_EQ(first.status, second.status) << i;
        EXPECT_EQ(first.time, second.time) << i;
        EXPECT_EQ(first.gap, second.gap) << i;
        hits += first.status == ToiStatus::Hit ? 1 : 0;
    }
    EXPECT_GT(hits, kInvariantScenes / 4);
}

TEST_P(RigidToiInvariance, UnitOfLengthDoesNotChangeTheTime)
{
    Random random(84);
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = query(scene);
        for (const double factor : {0x1p-20, 0x1p20, 1e-3, 1e3})
        {
            const ToiResult second = query(scaled(scene, factor), kSearchTolerance * factor);
            const bool isPowerOfTwo = factor == 0x1p-20 || factor == 0x1p20;
            EXPECT_EQ(first.status, second.status) << i;
            EXPECT_NEAR(first.time, second.time, isPowerOfTwo ? 1e-12 : 1e-6) << i;
        }
    }
}

/// A motion that the library knows, handed over as one that it does not.
class Wrapped : public UserMotion
{
public:
    explicit Wrapped(const RigidMotion& motion) : m_motion(motion) {}
    [[nodiscard]] MotionState at(double t) const override { return m_motion.at(t); }
    [[nodiscard]] AccelerationBound accelerationBound() const override
    {
        return m_motion.accelerationBound();
    }

private:
    RigidMotion m_motion;
};

TEST_P(RigidToiInvariance, AUserMotionGivesTheAnswerOfTheMotionThatItEquals)
{
    Random random(88);
    int hits = 0;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        RigidScene scene = randomRigidScene(random);
        scene.motionA.reference_B =
            random.chance(0.5) ? random.inBox(1.0) : Eigen::Vector3d::Zero();
        const Wrapped userA(scene.motionA);
        const Wrapped userB(scene.motionB);
        const SsvTree treeA = buildSsvTree(scene.meshA);
        const SsvTree treeB = buildSsvTree(scene.meshB);
        ToiWorkspace work;
        const ToiOptions options{.tolerance = kSearchTolerance, .strategy = GetParam()};
        const ToiResult known = query(scene);
        const ToiResult user = rigidToi({.tree = &treeA, .userMotion = &userA},
                                        {.tree = &treeB, .userMotion = &userB},
                                        options,
                                        work);
        expectSameContact(scene, known, user, std::to_string(i));
        const Judgement judgement = judgeToi(scene, options, user);
        EXPECT_EQ(judgement.verdict, Verdict::Right) << i << ": " << judgement.text();
        hits += user.status == ToiStatus::Hit ? 1 : 0;
    }
    EXPECT_GT(hits, kInvariantScenes / 5);
}

/// Swings there and back on a circle of radius 1 about the origin: angle sin(pi t).
class Swing : public UserMotion
{
public:
    [[nodiscard]] MotionState at(double t) const override
    {
        const double angle = std::sin(kPi * t);
        const double rate = kPi * std::cos(kPi * t);
        MotionState state{.X_W = poseOf(Eigen::Vector3d::Zero(), angle)};
        state.w_W = {0, 0, rate};
        return state;
    }
    [[nodiscard]] AccelerationBound accelerationBound() const override
    {
        // Centripetal pi^2 cos^2 and tangential pi^2 sin: at most sqrt(2) pi^2 together.
        return {.constant = 0.0, .perRadius = std::numbers::sqrt2 * kPi * kPi};
    }

private:
    static constexpr double kPi = std::numbers::pi;
};

TEST_P(RigidToiInvariance, AUserMotionMeetsItsClosedForm)
{
    // A rod of length 2 along x meets the wall y = h at sin(angle) = h / 2, angle = sin(pi t).
    const Swing swing;
    const SsvTree rod = buildSsvTree(segment({0, 0, 0}, {2, 0, 0}));
    ToiWorkspace work;
    for (const double h : {0.1, 0.5, 1.0, 1.6})
    {
        const SsvTree wall = buildSsvTree(wallAtY(h, 4.0));
        const double exact = std::asin(std::asin(0.5 * h)) / std::numbers::pi;
        const ToiResult result = rigidToi({.tree = &rod, .userMotion = &swing},
                                          {.tree = &wall},
                                          {.tolerance = 1e-8, .strategy = GetParam()},
                                          work);
        ASSERT_EQ(result.status, ToiStatus::Hit) << h;
        EXPECT_LE(result.time, exact + 1e-15) << h;
        EXPECT_GE(result.time, exact - 1e-7) << h;
    }
    // sin(1) is the farthest that it comes.
    const SsvTree wall = buildSsvTree(wallAtY(2.0 * std::sin(1.0) + 1e-6, 4.0));
    EXPECT_EQ(rigidToi({.tree = &rod, .userMotion = &swing},
                       {.tree = &wall},
                       {.tolerance = 1e-7, .strategy = GetParam()},
                       work)
                  .status,
              ToiStatus::Separated);
}

TEST(RigidToi, AllStrategiesFindTheSameContact)
{
    Random random(89);
    int hits = 0;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = queryToi(scene, kSearchTolerance);
        hits += first.status == ToiStatus::Hit ? 1 : 0;
        for (const ToiStrategy strategy : {ToiStrategy::Interval, ToiStrategy::C2A})
        {
            const ToiResult other =
                queryToi(scene, {.tolerance = kSearchTolerance, .strategy = strategy});
            expectSameContact(scene, first, other, nameOf(strategy) + std::to_string(i));
        }
    }
    EXPECT_GT(hits, kInvariantScenes / 4);
}

TEST(RigidToi, RepeatingAQueryGivesTheSameBits)
{
    Random random(85);
    ToiWorkspace work;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const SsvTree treeA = buildSsvTree(scene.meshA);
        const SsvTree treeB = buildSsvTree(scene.meshB);
        const ToiOptions options{.tolerance = kSearchTolerance};
        const ToiResult first =
            rigidToi({&treeA, scene.motionA}, {&treeB, scene.motionB}, options, work);
        const ToiResult second = queryToi(scene, kSearchTolerance);
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
    for (int i = 0; i < kInvariantScenes; ++i)
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
    EXPECT_GT(hits, kInvariantScenes);
}

TEST(RigidToi, ALongerHorizonKeepsTheContact)
{
    Random random(87);
    int hits = 0;
    for (int i = 0; i < kInvariantScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiResult first = queryToi(scene, kSearchTolerance);
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
        const ToiResult second = queryToi(longer, kSearchTolerance);
        ASSERT_EQ(second.status, ToiStatus::Hit) << i;
        EXPECT_NEAR(2.0 * second.time, first.time, 0.02) << i;
        EXPECT_LE(distanceAt(longer, second.time), kSearchTolerance + roundingOf(longer)) << i;
    }
    EXPECT_GT(hits, kInvariantScenes / 4);
}
}  // namespace
}  // namespace bullet_ccd::tests
