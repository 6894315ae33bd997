/// Boxes around hierarchies at rest and in motion.
#pragma once

#include "bullet_ccd/motion/frame_sweep.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <Eigen/Geometry>

namespace bullet_ccd
{
/// The volume of the whole hierarchy, in the mesh's frame.
[[nodiscard]] OrientedBox rootBox(const SsvTree& tree);

/// Encloses the body at all times of [begin, end], in W.
[[nodiscard]] Eigen::AlignedBox3d boundsOver(const RigidBody& body, double begin, double end);
}  // namespace bullet_ccd
