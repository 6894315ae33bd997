/// Articulated queries by motion bounds of first order: what the literature does, to be compared
/// with the bound of second order that articulatedToi() has.
#pragma once

#include "bullet_ccd/motion/moving_frames.h"
#include "bullet_ccd/toi/articulated_toi.h"

namespace bullet_ccd::benchmarks
{
/// How the motion of a link over the time ahead is bounded. Both bounds are conservative.
enum class FirstOrderBound : std::uint8_t
{
    Directional,  ///< by the speed of every joint along the direction in question
    Sum,          ///< by the speeds of all joints, in whatever direction
};

/// Bound of the speed along the unit vector n, in W, of points within `radius` of the frame's
/// origin, at all times of [t, t + ahead].
///
/// A joint k turns points at its reach by at most |q'_k| |n x z_k| reach; until then its axis has
/// turned by at most the sum of the turns of the joints above it, so the angle between n and z_k is
/// not nearer to a right angle than that allows.
[[nodiscard]] double directionalSpeed(MovingFrames& frames,
                                      std::int32_t frame,
                                      const Eigen::Vector3d& n,
                                      double t,
                                      double ahead,
                                      double radius);

/// First contact of the links with obstacles, by the same best-first search as articulatedToi(),
/// but with steps that are the gap over a bound of the speed, and without culling by space, which
/// costs nothing beside those. Links at rest are not tested, nor are links against each other. What
/// is within the tolerance at t = 0 overlaps.
/// @pre the obstacles rest
[[nodiscard]] ArticulatedToiResult firstOrderToi(const ArticulatedBody& body,
                                                 std::span<const RigidBody> obstacles,
                                                 FirstOrderBound bound,
                                                 const ToiOptions& options);
}  // namespace bullet_ccd::benchmarks
