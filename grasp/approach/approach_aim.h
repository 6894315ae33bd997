/// Lines along which a hand comes at points of an object, and the limits of a user.
#pragma once

#include "grasp/approach/approach.h"
#include "grasp/approach/draws.h"
#include "grasp/approach/object_shape.h"

namespace bullet_ccd::grasp
{
/// A point, and the direction in which the hand comes at it.
struct ApproachAim
{
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();   ///< unit
    Eigen::Vector3d opposition = Eigen::Vector3d::Zero();  ///< unit, across it: for the fingers
};

/// A point of the surface, with probability by area, and the direction against the normal by which
/// its triangle is wound; the opposition is left zero. For tableTop of the part of the surface
/// whose normals are within maxTilt of up, if there is any.
[[nodiscard]] ApproachAim surfaceAim(const GraspObject& object,
                                     const ApproachOptions& options,
                                     Draws& draws);

/// Point `number` of a sequence that spreads evenly over faces of the object's principal box, which
/// take turns, at right angles to the face, with the opposition along its shorter side. `sequence`
/// shifts all points. For tableTop faces whose normals are within maxTilt of up, else the one
/// nearest to it.
[[nodiscard]] ApproachAim boxAim(const GraspObject& object,
                                 const ObjectShape& shape,
                                 const ApproachOptions& options,
                                 std::int64_t number,
                                 Draws& sequence);

/// Two points of the surface that face each other no farther apart than `opening` [m], square
/// enough for fingers to pinch it there, and a direction across the line between them, along which
/// fingers come at both with nothing of the object in their way. The point is in the middle between
/// them, and the opposition along the line. Of some draws the one that has the most room and is
/// nearest to the centre of mass; where none is found, the last one. For tableTop directions are
/// within maxTilt of down.
[[nodiscard]] ApproachAim pinchAim(const GraspObject& object,
                                   double opening,
                                   const ApproachOptions& options,
                                   Draws& draws);

/// The middle of the object on the line through `point` along `direction`; where the line misses
/// it, the foot of its centre of mass.
[[nodiscard]] Eigen::Vector3d middleOnLine(const GraspObject& object,
                                           const Eigen::Vector3d& point,
                                           const Eigen::Vector3d& direction);

/// Rotation with z along `z` and x as near to `x` as that allows.
[[nodiscard]] Eigen::Matrix3d frameFrom(const Eigen::Vector3d& z, const Eigen::Vector3d& x);

/// The direction itself, or the nearest one within maxTilt of -up for tableTop.
[[nodiscard]] Eigen::Vector3d withinTilt(const Eigen::Vector3d& direction,
                                         const ApproachOptions& options);

/// The frame with z within the tilt and with a roll within the limits: its own, or any of them.
[[nodiscard]] Eigen::Matrix3d withinLimits(const Eigen::Matrix3d& frame,
                                           const ApproachOptions& options,
                                           Draws& draws);
}  // namespace bullet_ccd::grasp
