/// Which way the volume of a node points: the axes of a small box around its triangles.
#pragma once

#include "bullet_ccd/hierarchy/ssv_points.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
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

/// The box of smallest surface along one of a triangle's edges, but for roundings of single
/// precision.
struct SsvTriangleBox
{
    SsvAxes axes;            ///< the longest extent first
    std::size_t corner;      ///< one of the triangle's
    Eigen::Vector3d center;  ///< from there
    Eigen::Vector3d half;
};
[[nodiscard]] SsvTriangleBox triangleBox(const SsvCorners& corners);

/// Axes of a box of small surface, the longest extent first: the principal axes, turned about each
/// other as long as that makes the box smaller. Large sets are judged by a sample: which axes are
/// taken is a matter of size, not of safety.
[[nodiscard]] SsvAxes smallBoxAxes(const SsvPoints& points);

/// How many boxes are turned at once, in the time of one.
inline constexpr std::size_t kSsvTurnedAtOnce = 4;

/// The same for 1 to kSsvTurnedAtOnce sets of points, beginning with axes that fit a part of each.
/// None depends on the others.
void turnToSmallBoxes(std::span<const SsvPoints> points, std::span<SsvAxes> axes);
}  // namespace bullet_ccd
