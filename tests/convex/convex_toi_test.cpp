// convexToi(): closed forms, statuses, invariances, and random queries under the judge of the rigid
// ones, which looks at the triangles of the shapes.
#include "bullet_ccd/convex/convex_toi.h"

#include "benchmarks/reference/queries/convex_queries.h"
#include "benchmarks/reference/queries/soak_tally.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/convex/kernels/moving_boxes.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;
using reference::Random;
constexpr double kPi = std::numbers::pi;

RigidMotion motion(const Vector3d& start, const Vector3d& v, const Vector3d& w = Vector3d::Zero())
{
    RigidMotion m{.v_W = v, .w_W = w};
    m.X_W0.translation() = start;
    return m;
}

ToiResult query(const ConvexShape& a,
                const RigidMotion& motionA,
                const ConvexShape& b,
                const RigidMotion& motionB,
                const ToiOptions& options = {.tolerance = 1e-6})
{
    return convexToi({.shape = &a, .motion = motionA}, {.shape = &b, .motion = motionB}, options);
}

/// A hit that is not late, and early by no more than the tolerance takes at that speed.
void expectHit(const ToiResult& result, double exact, double speed, double tolerance = 1e-6)
{
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_LE(result.time, exact + 1e-13);
    EXPECT_GE(result.time, exact - tolerance / speed);
    EXPECT_GT(result.gap, 0.0);
    EXPECT_LE(result.gap, tolerance);
    EXPECT_NEAR((result.pointB - result.pointA - result.gap * result.normal).norm(), 0.0, 1e-9);
}

const RigidMotion kRest = motion(Vector3d::Zero(), Vector3d::Zero());

TEST(ConvexToi, TwoSpheres)
{
    // Centres at (3 - 5 t, 0.5, 0) and 0: at the distance 1 where (3 - 5 t)^2 = 3/4.
    const ConvexShape big = sphereShape(0.7);
    const ConvexShape small = sphereShape(0.3);
    const ToiResult result = query(big, motion({3, 0.5, 0}, {-5, 0, 0}, {1, 2, 3}), small, kRest);
    expectHit(result, (3.0 - std::sqrt(0.75)) / 5.0, 5.0 * std::sqrt(0.75));
    EXPECT_NEAR(result.normal.x(), -std::sqrt(0.75), 1e-5);
}

TEST(ConvexToi, SphereOnPlane)
{
    const ConvexShape ball = sphereShape(0.25);
    const ConvexShape ground = halfSpaceShape({0, 0, 2}, 0.5);
    const ToiResult result = query(ball, motion({7, 0, 2}, {3, 0, -2}, {9, 0, 0}), ground, kRest);
    expectHit(result, (2.0 - 0.75) / 2.0, 2.0);
    EXPECT_NEAR(result.normal.z(), -1.0, 1e-15);
    // The other way round.
    const ToiResult swapped = query(ground, kRest, ball, motion({7, 0, 2}, {3, 0, -2}, {9, 0, 0}));
    EXPECT_EQ(swapped.time, result.time);
    EXPECT_EQ(swapped.pointA, result.pointB);
    EXPECT_NEAR(swapped.normal.z(), 1.0, 1e-15);
}

TEST(ConvexToi, BoxCornerTurnsIntoPlane)
{
    // The lower edge of a turning box of half size h is h (|sin| + |cos|) = sqrt(2) h sin(a + pi/4)
    // below its centre.
    const ConvexShape cube = boxShape({0.5, 0.5, 0.5});
    const ConvexShape ground = halfSpaceShape({0, 0, 1});
    const double height = 0.6;
    const double exact = (std::asin(height / std::sqrt(0.5)) - 0.25 * kPi) / 1.5;
    const ToiResult result =
        query(cube, motion({0, 0, height}, Vector3d::Zero(), {0, 1.5, 0}), ground, kRest);
    const double speed = 1.5 * std::sqrt(0.5) * std::cos(1.5 * exact + 0.25 * kPi);
    expectHit(result, exact, speed);
    // So does a box of that plane's size, whose upper face is the plane.
    const ConvexShape table = boxShape({4, 4, 1});
    expectHit(query(cube,
                    motion({0, 0, height}, Vector3d::Zero(), {0, 1.5, 0}),
                    table,
                    motion({0, 0, -1}, Vector3d::Zero())),
              exact,
              speed);
    // Just higher than the corner ever comes.
    EXPECT_EQ(query(cube,
                    motion({0, 0, std::sqrt(0.5) + 1e-9}, Vector3d::Zero(), {0, 1.5, 0}),
                    ground,
                    kRest,
                    {.tolerance = 1e-10})
                  .status,
              ToiStatus::Separated);
}

TEST(ConvexToi, CrossedCapsules)
{
    // Axes along z and, after a quarter turn about y, along x.
    const ConvexShape capsule = capsuleShape(0.2, 1.0);
    RigidMotion across = motion({0.3, 2, 0.4}, {0, -4, 0});
    across.X_W0.linear() = Eigen::AngleAxisd(0.5 * kPi, Vector3d::UnitY()).toRotationMatrix();
    expectHit(query(capsule, across, capsule, kRest), (2.0 - 0.4) / 4.0, 4.0);
    // End to end: half spheres.
    const ToiResult result = query(capsule, motion({0.24, 0, 4}, {0, 0, -4}), capsule, kRest);
    const double height = 2.0 + std::sqrt(0.16 - 0.24 * 0.24);
    expectHit(result, (4.0 - height) / 4.0, 4.0 * 0.8);
}

TEST(ConvexToi, CylinderRollsAgainstWall)
{
    // Its axis is along y; it rolls on the ground along x, whatever it turns by.
    const ConvexShape wheel = cylinderShape(0.5, 0.2);
    const ConvexShape wall = boxShape({0.1, 2, 2});
    RigidMotion roll = motion({-2, 0, 0.5 + 1e-4}, {3, 0, 0}, {0, 3 / 0.5, 0});
    roll.X_W0.linear() = Eigen::AngleAxisd(0.5 * kPi, Vector3d::UnitX()).toRotationMatrix();
    const ToiResult result = query(wheel, roll, wall, kRest);
    expectHit(result, (2.0 - 0.5 - 0.1) / 3.0, 3.0);
    // Above the ground nothing happens, all the way.
    const ConvexShape ground = halfSpaceShape({0, 0, 1});
    EXPECT_EQ(query(wheel, roll, ground, kRest).status, ToiStatus::Separated);
}

TEST(ConvexToi, ConeTipsOver)
{
    // A cone of radius 0.3 and height 0.8 turns about y from upright; its rim reaches down by
    // 0.3 sin a + 0.4 cos a = 0.5 sin(a + asin(0.8)) below its middle.
    const ConvexShape cone = coneShape(0.3, 0.4);
    const ConvexShape ground = halfSpaceShape({0, 0, 1});
    const double height = 0.45;
    const double exact = std::asin(height / 0.5) - std::asin(0.8);
    const double speed = 0.5 * std::cos(std::asin(height / 0.5));
    expectHit(query(cone, motion({0, 0, height}, Vector3d::Zero(), {0, 1, 0}), ground, kRest),
              exact,
              speed);
    const ConvexShape table = boxShape({4, 4, 1});
    expectHit(query(cone,
                    motion({0, 0, height}, Vector3d::Zero(), {0, 1, 0}),
                    table,
                    motion({0, 0, -1}, Vector3d::Zero())),
              exact,
              speed);
    // The tip, downwards.
    expectHit(query(cone, motion({0, 0, 2}, {0, 0, -3}, {0, 0, 5}), ground, kRest),
              (2.0 - 0.4) / 3.0,
              3.0);
}

TEST(ConvexToi, EdgesCross)
{
    // Two cubes on their edges: one along x above one along y, both turned by an eighth.
    const ConvexShape cube = boxShape({0.5, 0.5, 0.5});
    RigidMotion upper = motion({0.1, 0.2, 3}, {0, 0, -2});
    upper.X_W0.linear() = Eigen::AngleAxisd(0.25 * kPi, Vector3d::UnitX()).toRotationMatrix();
    RigidMotion lower = kRest;
    lower.X_W0.linear() = Eigen::AngleAxisd(0.25 * kPi, Vector3d::UnitY()).toRotationMatrix();
    expectHit(query(cube, upper, cube, lower), (3.0 - std::sqrt(2.0)) / 2.0, 2.0);
    // A hull of the same corners does the same.
    std::vector<Vector3d> corners;
    for (int i = 0; i < 8; ++i)
    {
        corners.emplace_back(
            (i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    }
    const ConvexShape hull = hullShape(corners);
    expectHit(query(hull, upper, cube, lower), (3.0 - std::sqrt(2.0)) / 2.0, 2.0);
}

TEST(ConvexToi, CommonMotionCostsOneLook)
{
    // A box rests on a turning, falling table: nothing moves between them.
    const ConvexShape cube = boxShape({0.5, 0.5, 0.5});
    const ConvexShape table = boxShape({2, 2, 0.5});
    RigidMotion top = motion({0.7, 0, 1.001}, {1, 2, -9}, {3, 5, 4});
    top.reference_B = {-0.7, 0, -1.001};
    const ToiResult result =
        query(cube, top, table, motion(Vector3d::Zero(), {1, 2, -9}, {3, 5, 4}));
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_LE(result.counters.states, 2);
}

TEST(ConvexToi, Statuses)
{
    const ConvexShape cube = boxShape({0.5, 0.5, 0.5});
    const ToiOptions options{.tolerance = 1e-3};
    const auto from = [&](double gap, double speed) {
        return query(cube, motion({1.0 + gap, 0.1, 0.2}, {speed, 0, 0}), cube, kRest, options);
    };
    EXPECT_EQ(from(-0.1, 1.0).status, ToiStatus::Overlapping);
    EXPECT_EQ(from(-0.1, 1.0).time, 0.0);
    EXPECT_EQ(from(5e-4, 1.0).status, ToiStatus::TouchingLeaving);
    EXPECT_EQ(from(5e-4, 1.0).time, 1.0);
    EXPECT_EQ(from(5e-4, 0.0).status, ToiStatus::TouchingLeaving);
    EXPECT_EQ(from(5e-4, -1.0).status, ToiStatus::TouchingPressing);
    EXPECT_LT(from(5e-4, -1.0).time, 5e-4);
    EXPECT_EQ(from(5e-3, 1.0).status, ToiStatus::Separated);
    EXPECT_EQ(from(5e-3, -1.0).status, ToiStatus::Hit);
    // Solids: one in the other overlaps.
    const ConvexShape marble = sphereShape(0.1);
    EXPECT_EQ(query(marble, motion({0.1, 0, 0}, {0.1, 0, 0}), cube, kRest).status,
              ToiStatus::Overlapping);
    EXPECT_EQ(query(marble, motion({0, 0, -1}, {0, 0, 3}), halfSpaceShape({0, 0, 1}), kRest).status,
              ToiStatus::Overlapping);
}

TEST(ConvexToi, KeepsClearance)
{
    const ConvexShape cube = boxShape({0.5, 0.5, 0.5});
    // Corner against corner, along the diagonal: the distance is not that of any face.
    const double s = 0.2;
    const Vector3d diagonal = Vector3d::Ones().normalized();
    const ToiResult result = query(cube,
                                   motion(Vector3d::Constant(1.0) + 1.2 * diagonal, -diagonal),
                                   cube,
                                   kRest,
                                   {.tolerance = 1e-6, .minimumSeparation = s});
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_LE(result.time, 1.0 + 1e-13);
    EXPECT_GE(result.time, 1.0 - 1e-6);
    EXPECT_GT(result.gap, s);
    EXPECT_LE(result.gap, s + 1e-6);
    EXPECT_NEAR((result.normal + diagonal).norm(), 0.0, 1e-9);
}

TEST(ConvexToi, GivesUpWhereItIsAsked)
{
    const ConvexShape cube = boxShape({0.5, 0.5, 0.5});
    const RigidMotion fall = motion({0.1, 0.2, 3}, {0, 0, -4}, {1, 2, 3});
    const ToiResult whole = query(cube, fall, cube, kRest);
    ASSERT_EQ(whole.status, ToiStatus::Hit);
    const ToiResult limited =
        query(cube, fall, cube, kRest, {.tolerance = 1e-6, .maxIterations = 1});
    EXPECT_EQ(limited.status, ToiStatus::IterationLimit);
    EXPECT_LT(limited.time, whole.time);
    const std::atomic<bool> cancelled = true;
    const ToiResult stopped =
        query(cube, fall, cube, kRest, {.tolerance = 1e-6, .stop = {.isCancelled = &cancelled}});
    EXPECT_EQ(stopped.status, ToiStatus::Stopped);
    EXPECT_LT(stopped.time, whole.time);
    // Coordinates that do not resolve the tolerance.
    const ToiResult far = query(cube,
                                motion({0, 0, 3}, {1e13, 0, -4}, {1, 2, 3}),
                                cube,
                                motion({0, 0, 0}, {0, 0, 0}, {3, 2, 1}),
                                {.tolerance = 1e-9});
    EXPECT_LE(far.time, 1.0);
}

TEST(ConvexToi, RefusesWhatIsNoQuery)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(static_cast<void>(boxShape({1, -1, 1})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(sphereShape(nan)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(capsuleShape(1, -1)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(cylinderShape(-1, 1)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(coneShape(1, nan)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(hullShape({})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(hullShape(std::vector<Vector3d>{{0, nan, 0}})),
                 std::invalid_argument);
    EXPECT_THROW(static_cast<void>(halfSpaceShape(Vector3d::Zero())), std::invalid_argument);
    const ConvexShape cube = boxShape({1, 1, 1});
    const ConvexShape ground = halfSpaceShape({0, 0, 1});
    EXPECT_THROW(static_cast<void>(query(ground, kRest, ground, kRest)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(query(cube, kRest, cube, kRest, {.tolerance = 0.0})),
                 std::invalid_argument);
    EXPECT_THROW(static_cast<void>(query(cube, motion({0, 0, 0}, {nan, 0, 0}), cube, kRest)),
                 std::invalid_argument);
    RigidMotion mirrored = kRest;
    mirrored.X_W0.linear()(0, 0) = -1.0;
    EXPECT_THROW(static_cast<void>(query(cube, kRest, cube, mirrored)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(convexToi({}, {.shape = &cube}, {})), std::invalid_argument);
}

/// Seen from elsewhere, and with the bodies swapped, the answer is the same but for the tolerance.
TEST(ConvexToi, DoesNotDependOnTheFrame)
{
    Random random(7);
    int hits = 0;
    constexpr std::uint64_t kQueries = 1200;
    for (std::uint64_t seed = 1; seed <= kQueries; ++seed)
    {
        const reference::ConvexQueryCase asked = reference::convexQuery(seed);
        const ToiResult one = convexToi(asked.body(0), asked.body(1), asked.options);
        const ToiResult swapped = convexToi(asked.body(1), asked.body(0), asked.options);
        reference::ConvexQueryCase elsewhere = asked;
        const Eigen::Isometry3d X = random.pose(3.0);
        for (RigidMotion& m : elsewhere.motions)
        {
            m = reference::moved(m, X);
        }
        const ToiResult other = convexToi(elsewhere.body(0), elsewhere.body(1), asked.options);
        for (const ToiResult& result : {swapped, other})
        {
            if (one.status == result.status)
            {
                // Along a grazing path a tolerance takes long.
                EXPECT_NEAR(one.time, result.time, 0.1) << seed;
                EXPECT_NEAR(one.gap, result.gap, 1.01 * asked.options.tolerance) << seed;
            }
        }
        hits += one.status == ToiStatus::Hit && one.status == other.status ? 1 : 0;
    }
    EXPECT_GT(hits, 0.3 * kQueries);
}

/// Every answer by proof or counterexample. benchmarks/run soak convex asks a million.
/// Closest points of round things carry each other by slivers, of which rounding says that they
/// hold what is beside them.
TEST(ConvexToi, RoundThingsTouchInPointsThatAreNearAndHaveANormal)
{
    Random random(5);
    int hits = 0;
    for (int i = 0; i < 3000; ++i)
    {
        const auto size = [&] { return random.uniform(0.2, 1.0); };
        const auto shape = [&](int kind)
        {
            switch (kind)
            {
                case 0:
                    return cylinderShape(size(), size());
                case 1:
                    return coneShape(size(), size());
                case 2:
                    return capsuleShape(size(), size());
                default:
                    return boxShape({size(), size(), size()});
            }
        };
        const ConvexShape a = shape(i % 2);
        const ConvexShape b = shape(i % 4);
        ConvexBody bodyA{.shape = &a};
        ConvexBody bodyB{.shape = &b};
        const Vector3d from = random.direction();
        bodyA.motion.X_W0 = random.pose(0.0);
        bodyA.motion.w_W = random.uniform(0.0, 3.0) * random.direction();
        bodyB.motion.X_W0 = random.pose(0.0);
        bodyB.motion.X_W0.translation() =
            4.0 * from + random.uniform(0.0, 0.7) * random.direction();
        bodyB.motion.v_W = -6.0 * from;
        bodyB.motion.w_W = random.uniform(0.0, 3.0) * random.direction();
        const double tolerance = std::pow(10.0, -random.integer(5, 9));
        const ToiResult result = convexToi(bodyA, bodyB, {.tolerance = tolerance});
        ASSERT_NE(result.status, ToiStatus::IterationLimit) << i;
        if (result.status != ToiStatus::Hit)
        {
            continue;
        }
        ++hits;
        const Vector3d across = result.pointB - result.pointA;
        EXPECT_NEAR(result.normal.norm(), 1.0, 1e-12) << i;
        EXPECT_LE(across.norm(), tolerance) << i;
        EXPECT_NEAR(across.norm(), result.gap, 1e-13) << i;
    }
    EXPECT_GT(hits, 2500);
}

/// The kernel for two boxes and the way that takes step by step, which is what queries with a
/// deadline take.
TEST(ConvexToi, KernelOfBoxesAgreesWithThePortableWay)
{
    if (boxKernel() == nullptr)
    {
        GTEST_SKIP() << "this processor has no kernel for boxes, or BULLET_CCD_SIMD forbids it";
    }
    constexpr int kQueries = 6000;
    int boxes = 0;
    int hits = 0;
    int sameSteps = 0;
    for (std::uint64_t seed = 0; boxes < kQueries; ++seed)
    {
        reference::ConvexQueryCase asked = reference::convexQuery(seed);
        if (asked.shapes[0].shape.core != ConvexCore::Box ||
            asked.shapes[1].shape.core != ConvexCore::Box)
        {
            continue;
        }
        ++boxes;
        const ToiResult fast = convexToi(asked.body(0), asked.body(1), asked.options);
        asked.options.stop = stopAfter(1e6);
        const ToiResult slow = convexToi(asked.body(0), asked.body(1), asked.options);
        ASSERT_EQ(fast.status, slow.status) << seed;
        // Both stop within a thousandth of the tolerance from the minimum separation.
        ASSERT_NEAR(fast.gap, slow.gap, 2e-3 * asked.options.tolerance + 1e-13) << seed;
        sameSteps += fast.counters.states == slow.counters.states ? 1 : 0;
        if (fast.status == ToiStatus::Hit)
        {
            ++hits;
            ASSERT_NEAR((fast.pointB - fast.pointA - fast.gap * fast.normal).norm(), 0.0, 1e-9)
                << seed;
        }
    }
    EXPECT_GT(hits, kQueries / 4);
    EXPECT_GT(sameSteps, kQueries / 2);
}

/// Boxes that lie on each other, face on face, shifted; from a gap within the tolerance on they
/// part, press, or slide. The answers have closed forms.
TEST(ConvexToi, BoxesThatTouchFaceOnFace)
{
    const ConvexShape box = boxShape({0.5, 0.5, 0.5});
    const ToiOptions options{.tolerance = 1e-3, .aim = 0.5};
    const Eigen::Vector3d offsets[] = {{0.0, 0.0, 0.0}, {0.3, -0.4, 0.0}, {0.9, 0.9, 0.0}};
    for (const Eigen::Vector3d& offset : offsets)
    {
        for (const double gap : {1e-4, 9e-4})
        {
            for (const double speed : {-1.0, -1e-5, 0.0, 1.0})
            {
                Eigen::Isometry3d X_WA = Eigen::Isometry3d::Identity();
                X_WA.translation() = offset + Eigen::Vector3d(0.0, 0.0, 1.0 + gap);
                RigidMotion motion = restAt(X_WA);
                motion.v_W = {0.1, 0.2, speed};
                const ConvexBody a{&box, motion};
                const ConvexBody b{&box, restAt(Eigen::Isometry3d::Identity())};
                const ToiResult result = convexToi(a, b, options);
                SCOPED_TRACE(std::to_string(offset.x()) + ", gap " + std::to_string(gap) +
                             ", speed " + std::to_string(speed));
                // What loses a tenth of its gap is not nearer than it was allowed to be.
                const bool presses = speed < -0.5;
                ASSERT_EQ(result.status,
                          presses ? ToiStatus::TouchingPressing : ToiStatus::TouchingLeaving);
                if (!presses)
                {
                    continue;
                }
                EXPECT_GT(result.gap, 0.0);
                EXPECT_LT(result.gap, 0.75 * gap + 1e-12);
                EXPECT_NEAR(result.time, (gap - result.gap) / -speed, 1e-9);
                EXPECT_NEAR((result.pointB - result.pointA).norm(), result.gap, 1e-12);
                EXPECT_NEAR(result.normal.z(), -1.0, 1e-12);
                // The points are on the boxes.
                EXPECT_LE((result.pointB.cwiseAbs() - box.half).maxCoeff(), 1e-12);
                const Eigen::Vector3d inA =
                    result.pointA - X_WA.translation() - result.time * motion.v_W;
                EXPECT_LE((inA.cwiseAbs() - box.half).maxCoeff(), 1e-12);
            }
        }
    }
}

TEST(ConvexToi, RandomQueriesAreRight)
{
    const std::uint64_t count = longTests() ? 60'000 : 1200;
    std::array<reference::SoakTally, reference::kConvexFamilies> tallies{};
    for (std::uint64_t seed = 1; seed <= count; ++seed)
    {
        const reference::ConvexQueryCase asked = reference::convexQuery(seed);
        const ToiResult result = convexToi(asked.body(0), asked.body(1), asked.options);
        const reference::Judgement judgement = reference::judgeConvex(asked, result);
        tallies[static_cast<std::size_t>(asked.family)].add(result.status, judgement.verdict);
        if (judgement.verdict != reference::Verdict::Right)
        {
            std::ostringstream text;
            print(text, asked);
            ADD_FAILURE() << "seed " << seed << ": " << judgement.text() << '\n' << text.str();
        }
    }
    EXPECT_EQ(reference::vacuity(tallies, reference::convexFamilyNames(), {}), "");
}
}  // namespace
}  // namespace bullet_ccd::tests
