/// One bounding volume around given triangles: the geometry of a node.
#pragma once

#include "bullet_ccd/hierarchy/ssv_axes.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace bullet_ccd
{
/// How the triangles of a node are enclosed; `first` and `count` are left zero.
///
/// Guarantee: as the node is stored, in single precision, every corner is inside.
struct SsvFit
{
    /// @param triangles at least one, in the tree's frame [m]
    /// @param axes of a small box around them
    /// @param scratch memory to reuse
    SsvNode (*enclose)(std::span<const SsvCorners> triangles,
                       const SsvAxes& axes,
                       std::vector<Eigen::Vector3d>& scratch);
};

/// The volume of all hierarchies: the box or, if that has less surface, a smaller box inside it
/// with the ball that it needs. How much smaller is chosen by a sample of the corners.
[[nodiscard]] SsvNode roundedBox(std::span<const SsvCorners> triangles,
                                 const SsvAxes& axes,
                                 std::vector<Eigen::Vector3d>& scratch);

/// A hierarchy of other volumes, to be compared with. Neither refit() nor a file knows of them.
[[nodiscard]] SsvTree buildSsvTree(TriangleMesh mesh, const SsvFit& fit);

/// Center and half-extents of a core, in coordinates along the axes.
struct SsvCore
{
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    Eigen::Vector3d half = Eigen::Vector3d::Zero();
};

/// The box with the given axes, without a ball.
[[nodiscard]] SsvNode boxNode(std::span<const SsvCorners> triangles, const SsvAxes& axes);

/// The core with the ball that it needs to reach all corners.
[[nodiscard]] SsvNode sweptNode(std::span<const SsvCorners> triangles,
                                const SsvAxes& axes,
                                const SsvCore& core);

/// Surface of a volume [m^2]: in proportion to the chance that a random line meets it.
[[nodiscard]] double ssvSurface(const SsvNode& node);
}  // namespace bullet_ccd
