/// Boxes about all that a hand passes through: what they do not meet, the hand cannot touch.
#pragma once

#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/hand/hand_model.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// Of one hand and preshape, computed once. In the frame of the hand's root link [m]; one box a
/// link, empty for a link without geometry.
struct SweptBoxes
{
    std::vector<Eigen::AlignedBox3d> open;     ///< of the links in the preshape
    std::vector<Eigen::AlignedBox3d> closing;  ///< of all that they pass through while closing
};

/// Every closing joint may be anywhere between its preshape and its limit, whatever the others do:
/// the boxes hold for all orders in which links are stopped, and a little beyond.
///
/// From a link to the root: a box in the link's frame is turned about the joint's axis over the
/// joint's range, boxed in that frame, and the box moved to the parent's. Along a direction e a
/// point p on such an arc is e.p_axis + A cos q + B sin q, so its extremes are at the ends of the
/// range or at q = atan2(B, A) and half a turn from there: the box of the arc is exact.
[[nodiscard]] SweptBoxes sweptBoxes(const HandModel& hand, const std::vector<double>& preshape);

/// The box moved along `shift` and all between.
[[nodiscard]] Eigen::AlignedBox3d sweptAlong(const Eigen::AlignedBox3d& box,
                                             const Eigen::Vector3d& shift);

/// True if the box, in a frame with pose X_WF, is apart from the body's bounding volume.
/// @pre the body rests
[[nodiscard]] bool isApart(const Eigen::AlignedBox3d& box,
                           const Eigen::Isometry3d& X_WF,
                           const RigidBody& body);

/// The bodies at rest, by index, that a hand may touch on its way along `shift` (W) and while it
/// closes anywhere on that way. X_WH is the pose of the root link where it begins.
[[nodiscard]] std::vector<std::int32_t> reachable(const SweptBoxes& boxes,
                                                  const Eigen::Isometry3d& X_WH,
                                                  const Eigen::Vector3d& shift,
                                                  std::span<const RigidBody> bodies);
}  // namespace bullet_ccd::grasp
