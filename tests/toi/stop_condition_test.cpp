/// Queries that are stopped by a deadline or from outside: what is certified by then is right.
#include "bullet_ccd/math/stop_condition.h"

#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/least_distance.h"
#include "tests/toi/cube_over_plane.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// A rigid motion that cancels the query which asks for it when it has been asked often enough.
class CancellingMotion : public UserMotion
{
public:
    CancellingMotion(const RigidMotion& motion, int after) : m_motion(motion), m_left(after) {}

    [[nodiscard]] MotionState at(double t) const override
    {
        m_isCancelled = m_isCancelled || --m_left < 0;
        return m_motion.at(t);
    }
    [[nodiscard]] AccelerationBound accelerationBound() const override
    {
        return m_motion.accelerationBound();
    }
    [[nodiscard]] StopCondition stop() const { return {.isCancelled = &m_isCancelled}; }

private:
    RigidMotion m_motion;
    mutable int m_left;
    mutable std::atomic<bool> m_isCancelled = false;
};

constexpr std::array kAllStrategies{
    ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A};

/// Two clouds of small triangles that drift through each other.
struct Clouds
{
    SsvTree a;
    SsvTree b;
    RigidMotion motionA{.X_W0 = poseOf({0.01, 0.02, 0.03}), .v_W = {0.3, 0.1, 0}};

    explicit Clouds(Random random)
        : a(buildSsvTree(soup(random, 1000, 1.0, 0.008))),
          b(buildSsvTree(soup(random, 1000, 1.0, 0.008)))
    {
    }
};

TEST(StopCondition, IsNotDueByItself)
{
    EXPECT_FALSE(StopCondition{}.isGiven());
    EXPECT_FALSE(StopCondition{}.isDue());
    EXPECT_FALSE(stopAfter(kNoBound).isGiven());
    EXPECT_TRUE(stopAfter(1e6).isGiven());
    EXPECT_FALSE(stopAfter(1e6).isDue());
    EXPECT_TRUE(stopAfter(0.0).isDue());
    for (const double past : {-1.0, -1e300, -kNoBound})
    {
        EXPECT_TRUE(stopAfter(past).isDue());
    }
    EXPECT_THROW(static_cast<void>(stopAfter(std::nan(""))), std::invalid_argument);
    std::atomic<bool> isCancelled = false;
    const StopCondition stop{.isCancelled = &isCancelled};
    EXPECT_TRUE(stop.isGiven());
    EXPECT_FALSE(stop.isDue());
    isCancelled = true;
    EXPECT_TRUE(stop.isDue());
}

TEST(StopCondition, AQueryWhoseTimeIsOverCertifiesNothingAndSaysSo)
{
    const RigidScene scene = cubeOverPlane(3.0, {0, 0, -8});
    const SsvTree a = buildSsvTree(scene.meshA);
    const SsvTree b = buildSsvTree(scene.meshB);
    const RigidBody bodyA{.tree = &a, .motion = scene.motionA};
    const RigidBody bodyB{.tree = &b, .motion = scene.motionB};
    ToiWorkspace work;
    for (const ToiStrategy strategy : kAllStrategies)
    {
        const ToiResult result =
            rigidToi(bodyA, bodyB, {.strategy = strategy, .stop = stopAfter(0.0)}, work);
        EXPECT_EQ(result.status, ToiStatus::Stopped);
        EXPECT_EQ(result.time, 0.0);
        EXPECT_TRUE(gaveUp(result.status));
        EXPECT_FALSE(isContact(result.status));
    }

    for (const double enough : {10.0, kNoBound})
    {
        const LeastDistanceResult least =
            leastDistance(bodyA, bodyB, {.enough = enough, .stop = stopAfter(0.0)}, work);
        EXPECT_EQ(least.status, ToiStatus::Stopped);
        EXPECT_EQ(least.distance, 0.0);
        EXPECT_EQ(least.found, enough);
    }

    KinematicTree tree;
    tree.links.resize(1);
    const JointMotion motion{.root = scene.motionA, .positions = {0.0}, .rates = {0.0}};
    const std::array<const SsvTree*, 1> linkTrees{&a};
    const ArticulatedBody body{
        .tree = &tree, .linkTrees = linkTrees, .motion = &motion, .selfPairs = {}};
    const std::array obstacles{bodyB};
    EXPECT_EQ(articulatedToi(body, obstacles, {}, work).status, ToiStatus::Hit);
    const ArticulatedToiResult whole =
        articulatedToi(body, obstacles, {.stop = stopAfter(0.0)}, work);
    EXPECT_EQ(whole.status, ToiStatus::Stopped);
    EXPECT_EQ(whole.time, 0.0);
    const ContactSequence sequence =
        articulatedContacts(body, obstacles, {.query = {.toi = {.stop = stopAfter(0.0)}}}, work);
    EXPECT_EQ(sequence.status, ToiStatus::Stopped);
    EXPECT_EQ(sequence.time, 0.0);

    DeformableSurface cloth(scene.meshA);
    DeformableSurface ground(scene.meshB);
    const RigidStep fall = rigidStep(scene.meshA, scene.motionA);
    cloth.setStep(fall.start, fall.end);
    const std::array<DeformableBody, 2> surfaces{DeformableBody{.surface = &cloth},
                                                 DeformableBody{.surface = &ground}};
    DeformableWorkspace space;
    EXPECT_EQ(deformableToi(surfaces, {}, space).status, ToiStatus::Hit);
    const DeformableResult soft = deformableToi(surfaces, {.stop = stopAfter(0.0)}, space);
    EXPECT_EQ(soft.status, ToiStatus::Stopped);
    EXPECT_EQ(soft.time, 0.0);
    EXPECT_TRUE(soft.contacts.empty());
}

TEST(StopCondition, WhatIsCertifiedWhenAQueryIsCancelledIsRight)
{
    const Clouds clouds(Random(3));
    const RigidBody resting{.tree = &clouds.b};
    ToiWorkspace work;
    double latest = 0.0;
    int stopped = 0;
    for (const ToiStrategy strategy : kAllStrategies)
    {
        const ToiResult truth = rigidToi(
            {.tree = &clouds.a, .motion = clouds.motionA}, resting, {.strategy = strategy}, work);
        ASSERT_EQ(truth.status, ToiStatus::Hit);
        for (int after = 0; after < 500; after += 1 + after / 2)
        {
            const CancellingMotion motion(clouds.motionA, after);
            const ToiResult result = rigidToi({.tree = &clouds.a, .userMotion = &motion},
                                              resting,
                                              {.strategy = strategy, .stop = motion.stop()},
                                              work);
            if (result.status != ToiStatus::Stopped)
            {
                EXPECT_EQ(result.status, ToiStatus::Hit);
                continue;
            }
            ++stopped;
            latest = std::max(latest, result.time);
            EXPECT_LE(result.time, truth.time);
        }
    }
    EXPECT_GT(stopped, 6);  // not only where they begin
    EXPECT_GT(latest, 0.0);
}

TEST(StopCondition, WhatIsCertifiedWhenAPairGivesUpHoldsForAllPairs)
{
    // The cube reaches one floor early and the other one late; whichever is asked first, and
    // wherever the query gives up.
    const SsvTree box = buildSsvTree(cube(1.0));
    const SsvTree early = buildSsvTree(floorAt(0.0, 100.0));
    const SsvTree late = buildSsvTree(floorAt(-4.0, 100.0));
    KinematicTree tree;
    tree.links.resize(1);
    const JointMotion motion{
        .root = {.X_W0 = poseOf({0.2, 0.1, 2.0}), .v_W = {0, 0, -8}, .w_W = {0.3, 0.2, 0.1}},
        .positions = {0.0},
        .rates = {0.0}};
    const std::array<const SsvTree*, 1> linkTrees{&box};
    const ArticulatedBody body{
        .tree = &tree, .linkTrees = linkTrees, .motion = &motion, .selfPairs = {}};
    ToiWorkspace work;
    for (const auto& [first, second] : {std::pair{&early, &late}, std::pair{&late, &early}})
    {
        const std::array obstacles{RigidBody{.tree = first}, RigidBody{.tree = second}};
        const Environment environment(obstacles);
        const ArticulatedToiResult truth = articulatedToi(body, environment, {}, work);
        ASSERT_EQ(truth.status, ToiStatus::Hit);
        for (const int culling : {0, 1, 2, 3})
        {
            ArticulatedToiOptions options{.cullBySpace = culling % 2 == 1,
                                          .cullByTime = culling / 2 == 1};
            int given = 0;
            for (options.toi.maxIterations = 1; options.toi.maxIterations < 400;
                 ++options.toi.maxIterations)
            {
                const ArticulatedToiResult result =
                    articulatedToi(body, environment, options, work);
                EXPECT_LE(result.time, truth.time + 1e-9);
                if (result.status == ToiStatus::Hit)
                {
                    EXPECT_NEAR(result.time, truth.time, 1e-3);
                    EXPECT_FALSE(result.contacts.empty());
                    continue;
                }
                EXPECT_EQ(result.status, ToiStatus::IterationLimit);
                ++given;
            }
            EXPECT_GT(given, 0);
            EXPECT_LT(given, 399);
        }
    }
}

TEST(StopCondition, OneThatNeverBecomesDueChangesNothing)
{
    const Clouds clouds(Random(4));
    const RigidBody a{.tree = &clouds.a, .motion = clouds.motionA};
    const RigidBody b{.tree = &clouds.b};
    ToiWorkspace work;
    for (const ToiStrategy strategy : kAllStrategies)
    {
        const ToiResult plain = rigidToi(a, b, {.strategy = strategy}, work);
        const ToiResult timed =
            rigidToi(a, b, {.strategy = strategy, .stop = stopAfter(1e6)}, work);
        EXPECT_EQ(timed.status, plain.status);
        EXPECT_EQ(timed.time, plain.time);
        EXPECT_EQ(timed.counters.nodePairs, plain.counters.nodePairs);
        EXPECT_EQ(timed.counters.trianglePairs, plain.counters.trianglePairs);
        // The limit of iterations still holds.
        const ToiResult few = rigidToi(
            a, b, {.strategy = strategy, .maxIterations = 100, .stop = stopAfter(1e6)}, work);
        EXPECT_EQ(few.status, ToiStatus::IterationLimit);
        EXPECT_LT(few.counters.nodePairs + few.counters.trianglePairs, 200);
    }
}

TEST(StopCondition, ADistanceThatIsStoppedIsBoundedFromBothSides)
{
    const Clouds clouds(Random(5));
    int incomplete = 0;
    for (const double shift : {2.0, 2.5, 4.0})
    {
        const Eigen::Isometry3d X_BA = poseOf({shift, 0.3, 0.1}, 0.7);
        const TrianglePair truth = treeDistance(clouds.a, clouds.b, X_BA, kNoBound);
        ASSERT_GT(truth.distance, 0.0);
        for (const double seconds : {0.0, 1e-6, 1e-5, 1e-4, 1e6})
        {
            const DistanceBounds bounds =
                distanceBounds(clouds.a, clouds.b, X_BA, kNoBound, stopAfter(seconds));
            EXPECT_LE(bounds.lowerBound, truth.distance);
            EXPECT_GE(bounds.nearest.distance, truth.distance);
            EXPECT_EQ(bounds.nearest.triangleA == kNone, bounds.nearest.distance == kNoBound);
            EXPECT_TRUE(!bounds.isComplete || bounds.nearest.distance == truth.distance);
            EXPECT_TRUE(!bounds.isComplete || bounds.lowerBound > (1.0 - 2e-6) * truth.distance);
            incomplete += bounds.isComplete ? 0 : 1;
        }
        EXPECT_GT(distanceBounds(clouds.a, clouds.b, X_BA, kNoBound, stopAfter(0.0)).lowerBound,
                  shift < 3.0 ? -1.0 : 0.0);
    }
    EXPECT_GE(incomplete, 3);
}
}  // namespace
}  // namespace bullet_ccd::tests
