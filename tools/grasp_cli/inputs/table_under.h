/// The table that an object stands on: boxes "table" whose upper faces touch the object, at its
/// place in W, from below, with their centres under its centre of mass.
#pragma once

#include "grasp/grasp_types.h"
#include "tools/support/obstacles/obstacle_list.h"

namespace bullet_ccd::tools
{
/// Wide and deep enough for any hand.
/// @param up  W, of any length but 0
[[nodiscard]] Obstacle tableUnder(const grasp::GraspObject& object, const Eigen::Vector3d& up);

/// As much of it as a picture shows.
[[nodiscard]] Obstacle shownTableUnder(const grasp::GraspObject& object, const Eigen::Vector3d& up);
}  // namespace bullet_ccd::tools
