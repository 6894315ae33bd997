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

/// Bound of the acceleration of a body: |acceleration| <= constant + perRadius * r for every point
/// at distance r from the body origin and every time of the step [m per step^2].
struct AccelerationBound
{
    double constant = 0.0;
    double perRadius = 0.0;
};

/// Motion by a constant twist, with any number of turns. A reference point of the body, by default
/// its origin, moves on a straight line, and the body turns about it. If the point is on the axis
/// of rotation, this is a screw motion.
struct BULLET_CCD_API RigidMotion
{
    Eigen::Isometry3d X_W0 = Eigen::Isometry3d::Identity();  ///< pose at t = 0
    Eigen::Vector3d v_W = Eigen::Vector3d::Zero();          ///< of the reference point [m per step]
    Eigen::Vector3d w_W = Eigen::Vector3d::Zero();          ///< angular velocity [rad per step]
    Eigen::Vector3d reference_B = Eigen::Vector3d::Zero();  ///< in the body frame [m]

    [[nodiscard]] MotionState at(double t) const;
    [[nodiscard]] AccelerationBound accelerationBound() const;
};

/// Any other motion, supplied by the user. The velocity that at() returns must be the derivative of
/// the pose, and accelerationBound() must hold. The guarantees of all queries rest on both.
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

/// Motion from one pose to another along the shortest arc. The poses of a half turn do not
/// determine the sense of rotation; then the axis whose first non-zero component is positive is
/// taken.
[[nodiscard]] BULLET_CCD_API RigidMotion motionBetween(const Eigen::Isometry3d& X_W0,
                                                       const Eigen::Isometry3d& X_W1);

/// Screw motion from one pose to another: a rotation by the shortest arc about a fixed axis of the
/// world and a translation along that axis. It does not depend on where the body origin is. Below
/// 1e-9 rad, where the axis is lost in rounding, it is motionBetween().
[[nodiscard]] BULLET_CCD_API RigidMotion screwBetween(const Eigen::Isometry3d& X_W0,
                                                      const Eigen::Isometry3d& X_W1);
}  // namespace bullet_ccd
