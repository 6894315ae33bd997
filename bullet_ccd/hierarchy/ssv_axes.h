/// Which way the volume of a node points: the axes of a small box around its triangles.
#pragma once

#include <Eigen/Core>

#include <array>
#include <span>

namespace bullet_ccd
{
/// The corners of a triangle in the tree's frame.
using SsvCorners = std::array<Eigen::Vector3d, 3>;

/// Axes as a node stores them: two columns in single precision, the third their cross product.
struct SsvAxes
{
    Eigen::Vector3f axis0;
    Eigen::Vector3f axis1;

    [[nodiscard]] Eigen::Matrix3d matrix() const;
};

/// Nearest floats. Not inlined: GCC 12 (-O2, vectorised) drops a conversion to float and back to
/// double within one function and goes on with the unrounded value, so that extents would be
/// measured about a center that is not the stored one.
[[nodiscard]] Eigen::Vector3f toFloats(const Eigen::Vector3d& x);

/// Axes of a box of small surface, the longest extent first.
///
/// A triangle has its box along one of its edges. Several start from their principal axes, which
/// are then turned about each other as long as that makes the box smaller. Large sets are judged
/// by a sample of their corners: which axes are taken is a matter of size, not of safety.
[[nodiscard]] SsvAxes smallBoxAxes(std::span<const SsvCorners> triangles);
}  // namespace bullet_ccd
