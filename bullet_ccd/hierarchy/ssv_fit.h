/// One bounding volume around given triangles: the geometry of a node.
#pragma once

#include "bullet_ccd/hierarchy/ssv_axes.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace bullet_ccd
{
/// The volume of the given kind around all triangles, small by surface; `first` and `count` are
/// left zero.
///
/// Guarantee: as the node is stored, in single precision, every corner is inside.
/// @param triangles at least one, in the tree's frame [m]
/// @param scratch memory to reuse
[[nodiscard]] SsvNode fitSsv(std::span<const SsvCorners> triangles,
                             SsvKind kind,
                             std::vector<Eigen::Vector3d>& scratch);

/// Surface of a volume [m^2]: in proportion to the chance that a random line meets it.
[[nodiscard]] double ssvSurface(const SsvNode& node);
}  // namespace bullet_ccd
