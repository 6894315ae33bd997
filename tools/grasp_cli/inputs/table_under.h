/// The table that an object stands on.
#pragma once

#include "grasp/grasp_types.h"
#include "tools/support/obstacles/obstacle_list.h"

namespace bullet_ccd::tools
{
/// A box "table" whose upper face touches the object, at its place in W, from below, with its
/// centre under the centre of mass.
/// @param up           W, of any length but 0
/// @param halfExtents  of the box, the last one along `up` [m]
[[nodiscard]] Obstacle tableUnder(const grasp::GraspObject& object,
                                  const Eigen::Vector3d& up,
                                  const Eigen::Vector3d& halfExtents);

/// The same, wide and deep enough for any hand.
[[nodiscard]] Obstacle tableUnder(const grasp::GraspObject& object, const Eigen::Vector3d& up);
}  // namespace bullet_ccd::tools
