/// Finds the flat faces of a mesh for its hierarchy (SsvTree::faceSlabs()).
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// @param corners of the triangles in the slots of the leaves
[[nodiscard]] FaceSlabs findFaceSlabs(std::span<const SsvNode> nodes,
                                      std::span<const std::array<Eigen::Vector3d, 3>> corners);

/// How many triangles are sampled at most, each so manieth in the order of the slots.
constexpr std::size_t kFaceSample = 4096;

/// The normals of the largest faces of a sample, the largest first.
[[nodiscard]] std::vector<Eigen::Vector3d> largestNormals(
    std::span<const std::array<Eigen::Vector3d, 3>> sample);

/// Of no point.
constexpr Slab kNoSlab{.low = std::numeric_limits<double>::infinity(),
                       .high = -std::numeric_limits<double>::infinity()};

/// Widens a slab by three corners.
void include(Slab& slab,
             const Eigen::Vector3d& normal,
             const std::array<Eigen::Vector3d, 3>& corners);

/// Fills the slabs of the nodes [begin, end) from the leaves up. Children that are not among them
/// have theirs. What is no node (kNone) is left out.
/// @param slabs of all nodes one along every normal
void fillSlabs(std::span<const Eigen::Vector3d> normals,
               std::span<const SsvNode> nodes,
               std::span<const std::array<Eigen::Vector3d, 3>> corners,
               std::size_t begin,
               std::size_t end,
               std::span<Slab> slabs);
}  // namespace bullet_ccd
