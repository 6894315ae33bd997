#include "bullet_ccd/motion/rigid_motion.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

double difference(const Isometry3d& a, const Isometry3d& b)
{
    return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(RigidMotion, FollowsTheExponentialMapForManyTurns)
{
    Random random(40);
    for (int i = 0; i < 300; ++i)
    {
        const double fastest = random.logUniform(1e-9, 700.0);
        const RigidMotion motion = randomRigidMotion(random, fastest);
        for (const double t : {0.0, 1.0, random.uniform(0.0, 1.0)})
        {
            const MotionState state = motion.at(t);
            // The angle itself is rounded to a few ulps of its size.
            EXPECT_LT(difference(state.X_W, oraclePose(motion, t)), 1e-14 + 1e-15 * fastest);
            EXPECT_EQ(state.v_W, motion.v_W);
            EXPECT_EQ(state.w_W, motion.w_W);
            const Eigen::Matrix3d R = state.X_W.linear();
            EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
        }
    }
}

TEST(RigidMotion, AtTimeZeroIsTheStartPoseExactly)
{
    Random random(41);
    const RigidMotion motion = randomRigidMotion(random, 3.0);
    EXPECT_LT(difference(motion.at(0.0).X_W, motion.X_W0), 1e-16);
    const Isometry3d X = random.pose(2.0);
    const RigidMotion rest = restAt(X);
    EXPECT_EQ(difference(rest.at(0.7).X_W, X), 0.0);
    EXPECT_EQ(rest.v_W.norm() + rest.w_W.norm(), 0.0);
}

TEST(RigidMotion, AccelerationBoundHoldsAndIsAttained)
{
    Random random(42);
    for (int i = 0; i < 200; ++i)
    {
        const RigidMotion motion = randomRigidMotion(random, random.uniform(0.0, 20.0));
        const AccelerationBound bound = motion.accelerationBound();
        const double turn = motion.w_W.norm();
        const double r = random.uniform(0.1, 3.0);
        // A point perpendicular to the axis has exactly the acceleration w^2 r.
        EXPECT_GE(bound.constant + bound.perRadius * r, turn * turn * r * (1.0 - 1e-14));
        EXPECT_LE(bound.constant + bound.perRadius * r, turn * turn * r * (1.0 + 1e-9) + 1e-12);
    }
}

TEST(MotionBetween, ReachesBothPosesAlongTheShortestArc)
{
    Random random(43);
    for (int i = 0; i < 500; ++i)
    {
        const Isometry3d X0 = random.pose(3.0);
        const Isometry3d X1 = random.pose(3.0);
        const RigidMotion motion = motionBetween(X0, X1);
        EXPECT_LT(difference(oraclePose(motion, 0.0), X0), 1e-15);
        EXPECT_LT(difference(oraclePose(motion, 1.0), X1), 1e-13);
        EXPECT_LE(motion.w_W.norm(), kPi + 1e-14);
    }
}

TEST(MotionBetween, KeepsTinyRotations)
{
    Random random(44);
    for (const double angle : {1e-3, 1e-6, 1e-9, 1e-12, 0.0})
    {
        const Isometry3d X0 = random.pose(1.0);
        const Vector3d axis = random.direction();
        Isometry3d X1 = X0;
        X1.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * X0.linear();
        const RigidMotion motion = motionBetween(X0, X1);
        // Matrix entries are rounded to 1e-16, so that is what is left of the rotation vector.
        EXPECT_LT((motion.w_W - angle * axis).norm(), 2e-15) << angle;
    }
}

TEST(MotionBetween, TakesThePositiveAxisAtAHalfTurn)
{
    Random random(45);
    for (const Vector3d& axis : {Vector3d(1, 0, 0),
                                 Vector3d(0, 1, 0),
                                 Vector3d(0, 0, 1),
                                 Vector3d(1, 2, -3).normalized(),
                                 Vector3d(0, 1, -1).normalized()})
    {
        for (const double sign : {1.0, -1.0})
        {
            Isometry3d X1 = Isometry3d::Identity();
            // Written out, 2 a a^T - 1, so that no sine of pi is left.
            X1.linear() = 2.0 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
            const RigidMotion motion = motionBetween(Isometry3d::Identity(), X1);
            EXPECT_NEAR(motion.w_W.norm(), kPi, 1e-7);
            EXPECT_LT((motion.w_W / kPi - axis).norm(), 1e-7) << axis.transpose() << sign;
            EXPECT_LT(difference(oraclePose(motion, 1.0), X1), 1e-14);
        }
    }
    for (int i = 0; i < 100; ++i)
    {
        const Isometry3d X0 = random.pose(1.0);
        Isometry3d X1 = X0;
        const double missing = random.logUniform(1e-14, 1e-2);
        const double angle = kPi - missing;
        const Vector3d axis = random.direction();
        X1.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * X0.linear();
        // What cannot be told from a half turn may be taken for one.
        const double allowed = missing < 1e-11 ? 1e-11 : 1e-13;
        EXPECT_LT(difference(oraclePose(motionBetween(X0, X1), 1.0), X1), allowed) << missing;
    }
}

/// A motion about a point of the body that need not be its origin.
RigidMotion randomReferenceMotion(Random& random, double fastest)
{
    RigidMotion motion = randomRigidMotion(random, fastest);
    motion.reference_B = random.inBox(2.0);
    return motion;
}

TEST(RigidMotion, TheReferenceMovesOnAStraightLineAndTheBodyTurnsAboutIt)
{
    Random random(46);
    for (int i = 0; i < 200; ++i)
    {
        const RigidMotion motion = randomReferenceMotion(random, random.logUniform(1e-6, 60.0));
        const Vector3d start = motion.X_W0 * motion.reference_B;
        const double rate = motion.w_W.norm();
        for (const double t : {0.0, 1.0, random.uniform(0.0, 1.0)})
        {
            const MotionState state = motion.at(t);
            const Vector3d reference = state.X_W * motion.reference_B;
            EXPECT_LT((reference - start - t * motion.v_W).norm(), 1e-13 + 1e-15 * rate);
            const Eigen::Matrix3d R =
                Eigen::AngleAxisd(t * rate, motion.w_W / rate).toRotationMatrix() *
                motion.X_W0.linear();
            EXPECT_LT((state.X_W.linear() - R).norm(), 1e-14 + 1e-15 * rate);
        }
    }
}

TEST(RigidMotion, VelocityIsTheDerivativeOfThePose)
{
    Random random(47);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 200; ++i)
    {
        const RigidMotion motion = randomReferenceMotion(random, 5.0);
        const double t = random.uniform(0.1, 0.9);
        const MotionState state = motion.at(t);
        const Vector3d p = random.inBox(2.0);
        const Vector3d difference =
            (motion.at(t + kStep).X_W * p - motion.at(t - kStep).X_W * p) / (2.0 * kStep);
        const Vector3d velocity =
            state.v_W + state.w_W.cross(state.X_W * p - state.X_W.translation());
        // Central differences: w^3 r h^2 / 6 of the curve and rounding / h.
        EXPECT_LT((difference - velocity).norm(), 3e-9);
    }
}

TEST(RigidMotion, AccelerationBoundHoldsForEveryPointOfABodyThatTurnsAboutAnother)
{
    Random random(48);
    for (int i = 0; i < 500; ++i)
    {
        const RigidMotion motion = randomReferenceMotion(random, 20.0);
        const AccelerationBound bound = motion.accelerationBound();
        const Vector3d p = random.inBox(3.0);
        const Vector3d arm =
            motion.at(random.uniform(0.0, 1.0)).X_W.linear() * (p - motion.reference_B);
        // Exact: centripetal.
        const double acceleration = motion.w_W.cross(motion.w_W.cross(arm)).norm();
        EXPECT_LE(acceleration, bound.constant + bound.perRadius * p.norm());
    }
}

TEST(RigidMotion, TheSameMotionFromAnotherBodyOriginIsTheSame)
{
    // Moving the body frame within the body changes X_W0 and reference_B, nothing else.
    Random random(49);
    for (int i = 0; i < 200; ++i)
    {
        const RigidMotion motion = randomReferenceMotion(random, 10.0);
        const Isometry3d X_BC = random.pose(5.0);
        RigidMotion other = motion;
        other.X_W0 = motion.X_W0 * X_BC;
        other.reference_B = X_BC.inverse() * motion.reference_B;
        for (const double t : {0.0, 0.3, 1.0})
        {
            EXPECT_LT(difference(other.at(t).X_W, motion.at(t).X_W * X_BC), 3e-14);
        }
    }
}

/// exp of a screw: rotation by t angle about the axis through `point`, shift of t pitch along it.
Isometry3d screwPose(const Vector3d& point, const Vector3d& axis, double angle, double pitch)
{
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    X.translation() = point - X.linear() * point + pitch * axis;
    return X;
}

TEST(ScrewBetween, FollowsTheClosedFormOfTheScrew)
{
    Random random(50);
    for (int i = 0; i < 500; ++i)
    {
        const Isometry3d X0 = random.pose(3.0);
        const Vector3d point = random.inBox(3.0);
        const Vector3d axis = random.direction();
        const double angle =
            random.chance(0.5) ? random.uniform(0.1, 3.0) : random.logUniform(1e-3, 0.1);
        const double pitch = random.uniform(-2.0, 2.0);
        const RigidMotion motion = screwBetween(X0, screwPose(point, axis, angle, pitch) * X0);
        for (const double t : {0.0, 0.25, 0.5, 1.0})
        {
            const Isometry3d expected = screwPose(point, axis, t * angle, t * pitch) * X0;
            // The axis is known to rounding / angle.
            EXPECT_LT(difference(motion.at(t).X_W, expected), 2e-14 / angle + 1e-13)
                << angle << ' ' << t;
        }
    }
}

TEST(ScrewBetween, ReachesBothPoses)
{
    Random random(51);
    for (int i = 0; i < 500; ++i)
    {
        const Isometry3d X0 = random.pose(3.0);
        Isometry3d X1 = random.pose(3.0);
        if (random.chance(0.4))
        {
            const double angle = random.logUniform(1e-12, 1e-2);
            X1.linear() =
                Eigen::AngleAxisd(angle, random.direction()).toRotationMatrix() * X0.linear();
        }
        const RigidMotion motion = screwBetween(X0, X1);
        EXPECT_LT(difference(motion.at(0.0).X_W, X0), 1e-13);
        // The axis is as far away as 1e12; that must not be felt.
        EXPECT_LT(difference(motion.at(1.0).X_W, X1), 1e-12);
    }
}

TEST(ScrewBetween, DoesNotDependOnWhereTheBodyOriginIs)
{
    Random random(52);
    double largestDifferenceOfOthers = 0.0;
    for (int i = 0; i < 300; ++i)
    {
        const Isometry3d X0 = random.pose(3.0);
        const Isometry3d X1 = random.pose(3.0);
        const Isometry3d X_BC = random.pose(4.0);
        const RigidMotion screw = screwBetween(X0, X1);
        if (screw.w_W.norm() < 0.05)
        {
            continue;
        }
        const RigidMotion other = screwBetween(X0 * X_BC, X1 * X_BC);
        const RigidMotion straight = motionBetween(X0, X1);
        const RigidMotion otherStraight = motionBetween(X0 * X_BC, X1 * X_BC);
        for (const double t : {0.3, 0.5, 0.8})
        {
            EXPECT_LT(difference(screw.at(t).X_W * X_BC, other.at(t).X_W), 1e-11);
            largestDifferenceOfOthers =
                std::max(largestDifferenceOfOthers,
                         difference(straight.at(t).X_W * X_BC, otherStraight.at(t).X_W));
        }
    }
    // The straight motion of the origin does depend on it: the relation is not trivial.
    EXPECT_GT(largestDifferenceOfOthers, 0.5);
}

TEST(ScrewBetween, IsATranslationWithoutRotation)
{
    Random random(53);
    const Isometry3d X0 = random.pose(1.0);
    Isometry3d X1 = X0;
    X1.translation() += Vector3d(1, 2, 3);
    const RigidMotion motion = screwBetween(X0, X1);
    EXPECT_LT((motion.v_W - Vector3d(1, 2, 3)).norm(), 1e-15);
    EXPECT_LT(motion.w_W.norm(), 1e-15);
}
}  // namespace
}  // namespace bullet_ccd::tests
