/// The volumes of a hierarchy: the geometry of its nodes.
#pragma once

#include "bullet_ccd/hierarchy/ssv_axes.h"
#include "bullet_ccd/hierarchy/ssv_node.h"
#include "bullet_ccd/hierarchy/ssv_points.h"
#include "bullet_ccd/hierarchy/ssv_split.h"

#include <span>

namespace bullet_ccd
{
/// A volume around given points: their box along the axes or, if that has less surface, a smaller
/// box inside it with the ball that it needs. How much smaller is chosen by a sample of the points.
///
/// Guarantee: as the node is stored, in single precision, every point is inside. `first` and
/// `count` are left zero.
[[nodiscard]] SsvNode roundedBox(const SsvPoints& points, const SsvAxes& axes);

/// The box around a triangle, with the same guarantee.
[[nodiscard]] SsvNode boxOfTriangle(const SsvCorners& corners);

/// Fits every node to the triangles below it, on all threads. The result does not depend on their
/// number.
/// @param corners of the triangles in the slots of the leaves
/// @param nodes as many as branches
void fitNodes(std::span<const SsvBranch> branches,
              std::span<const SsvCorners> corners,
              std::span<SsvNode> nodes);
}  // namespace bullet_ccd
