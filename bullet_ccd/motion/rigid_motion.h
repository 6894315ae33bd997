/// Motion of one rigid body over a step: the origin of the body frame moves on a straight line, the
/// body turns about it with constant angular velocity. Time t runs over [0, 1].
#pragma once

#include <Eigen/Geometry>

namespace bullet_ccd
{
/// Pose and velocity of a body at one time, in the frame of the query (usually the world W).
struct MotionState
{
    Eigen::Isometry3d X_W = Eigen::Isometry3d::Identity();
    Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< velocity of the body origin [m per step]
    Eigen::Vector3d w_W = Eigen::Vector3d::Zero();  ///< angular velocity [rad per step]
};

/// For every point at distance r from the body origin and every time of the step:
/// |acceleration| <= constant + perRadius * r.
struct AccelerationBound
{
    double constant = 0.0;
    double perRadius = 0.0;
};

/// Twist form; any number of turns.
struct RigidMotion
{
    Eigen::Isometry3d X_W0 = Eigen::Isometry3d::Identity();  ///< pose at t = 0
    Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< velocity of the body origin [m per step]
    Eigen::Vector3d w_W = Eigen::Vector3d::Zero();  ///< angular velocity [rad per step]

    [[nodiscard]] MotionState at(double t) const;
    [[nodiscard]] AccelerationBound accelerationBound() const;
};

/// A body at rest.
[[nodiscard]] RigidMotion restAt(const Eigen::Isometry3d& X_W);

/// Motion from one pose to another along the shortest arc. At a half turn the sense of rotation is
/// not determined by the poses: the axis with its first non-zero component positive is taken.
[[nodiscard]] RigidMotion motionBetween(const Eigen::Isometry3d& X_W0,
                                        const Eigen::Isometry3d& X_W1);
}  // namespace bullet_ccd
