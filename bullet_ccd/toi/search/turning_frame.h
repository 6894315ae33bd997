/// Relative motion as it is seen from the turning frame of one of the bodies.
#pragma once

#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"

#include <optional>

namespace bullet_ccd
{
/// Body B of a relative motion, for a turn of the frame.
struct TurningBody
{
    double perRadius = 0.0;  ///< of the bound of its acceleration, see AccelerationBound
    Eigen::Vector3d arm =
        Eigen::Vector3d::Zero();  ///< from where that counts to the origin of its tree
};

/// The same relative motion with directions that turn with B: B rests, and a direction along which
/// it is apart from A stays one of its own. Seen from there a point of A accelerates by at most
///   |x''| + |b''| + 2 |wB| |u|,
/// where b'' is the acceleration of B at the place of the point, u the velocity of the point
/// relative to B there, and |wB|^2 no more than the bound of B's acceleration per radius
/// (bullet_ccd/toi/README.md, "Relative motion").
///
/// Guarantee: holds from the time of `motion` on for the `rest` of the step, and for all points of
/// A within `radius` of the origin of its tree.
/// None where the bounds are too coarse to close, and where B does not turn.
/// @pre accelerations of A make no use of its axis (axisA is 0)
[[nodiscard]] std::optional<RelativeMotion> seenFromB(const RelativeMotion& motion,
                                                      const TurningBody& b,
                                                      double radius,
                                                      double rest);

/// The same relative motion with the roles of A and B changed.
/// @pre the reference of A is the origin of its tree (armA is 0), and accelerations make no use of
/// axes. B's own acceleration is that of A, whose `perRadius` and arm are to be kept.
[[nodiscard]] RelativeMotion swapped(const RelativeMotion& motion);
}  // namespace bullet_ccd
