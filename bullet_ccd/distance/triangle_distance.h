/// Exact distance of two triangles with witnesses; degenerate triangles count as the segments or
/// points that they are.
#pragma once

#include <Eigen/Core>

#include <array>

namespace bullet_ccd
{
using TriangleCorners = std::array<Eigen::Vector3d, 3>;

struct TriangleDistance
{
    double distance = 0.0;  ///< 0 if they touch or intersect
    Eigen::Vector3d pointA =
        Eigen::Vector3d::Zero();  ///< a closest point of A (an intersection point if distance == 0)
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();  ///< of B
};

/// Distance of two triangles given in one common frame. Never throws, allocates nothing.
[[nodiscard]] TriangleDistance triangleDistance(const TriangleCorners& a, const TriangleCorners& b);
}  // namespace bullet_ccd
