#include "bullet_ccd/motion/rigid_motion.h"

#include "tests/oracles/brute_force_toi.h"
#include "tests/support/random_trees.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
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
}  // namespace
}  // namespace bullet_ccd::tests
