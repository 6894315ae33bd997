/// Finds the flat faces of a mesh for its hierarchy (SsvTree::faceSlabs()).
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <array>
#include <span>

namespace bullet_ccd
{
/// @param corners of the triangles in the slots of the leaves
[[nodiscard]] FaceSlabs findFaceSlabs(std::span<const SsvNode> nodes,
                                      std::span<const std::array<Eigen::Vector3d, 3>> corners);
}  // namespace bullet_ccd
