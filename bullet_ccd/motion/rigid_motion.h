/// Motion of one rigid body over a step. Time t runs over [0, 1].
#pragma once

#include "bullet_ccd/export.h"

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

/// Twist form; any number of turns. A point of the body, by default its origin, moves on a straight
/// line, the body turns about it. With the point on its axis this is a screw motion.
struct BULLET_CCD_API RigidMotion
{
    Eigen::Isometry3d X_W0 = Eigen::Isometry3d::Identity();  ///< pose at t = 0
    Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< velocity of the reference [m per step]
    Eigen::Vector3d w_W = Eigen::Vector3d::Zero();  ///< angular velocity [rad per step]
    Eigen::Vector3d reference_B = Eigen::Vector3d::Zero();  ///< in the body frame [m]

    [[nodiscard]] MotionState at(double t) const;
    [[nodiscard]] AccelerationBound accelerationBound() const;
};

/// Any other motion, supplied by the user. The derivative of the pose must be the velocity that
/// at() gives, and accelerationBound() must hold: the certificate of a query rests on both.
class BULLET_CCD_API UserMotion
{
public:
    virtual ~UserMotion() = default;
    [[nodiscard]] virtual MotionState at(double t) const = 0;
    [[nodiscard]] virtual AccelerationBound accelerationBound() const = 0;
};

/// A body at rest.
[[nodiscard]] BULLET_CCD_API RigidMotion restAt(const Eigen::Isometry3d& X_W);

/// The part of the motion from `begin` to `end` as a motion over [0, 1].
[[nodiscard]] BULLET_CCD_API RigidMotion partOf(const RigidMotion& motion,
                                                double begin,
                                                double end);

/// Motion from one pose to another along the shortest arc. At a half turn the sense of rotation is
/// not determined by the poses: the axis with its first non-zero component positive is taken.
[[nodiscard]] BULLET_CCD_API RigidMotion motionBetween(const Eigen::Isometry3d& X_W0,
                                                       const Eigen::Isometry3d& X_W1);

/// Screw motion from one pose to another: rotation about a fixed axis of the world by the shortest
/// arc, translation along it. Independent of where the body origin is. Without rotation (less than
/// 1e-9 rad, where the axis is lost in rounding) the same as motionBetween().
[[nodiscard]] BULLET_CCD_API RigidMotion screwBetween(const Eigen::Isometry3d& X_W0,
                                                      const Eigen::Isometry3d& X_W1);
}  // namespace bullet_ccd
