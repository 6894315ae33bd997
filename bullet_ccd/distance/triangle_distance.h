/// Exact distance of two triangles with witnesses; degenerate triangles count as the segments or
/// points that they are.
#pragma once

#include "bullet_ccd/export.h"

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
[[nodiscard]] BULLET_CCD_API TriangleDistance triangleDistance(const TriangleCorners& a,
                                                               const TriangleCorners& b);
/// Closest points of a point and a triangle (B).
[[nodiscard]] BULLET_CCD_API TriangleDistance pointToTriangle(const Eigen::Vector3d& point,
                                                              const TriangleCorners& triangle);

/// Closest points of the segments from p0 to p1 (A) and from q0 to q1 (B), which may be points.
[[nodiscard]] TriangleDistance segmentToSegment(const Eigen::Vector3d& p0,
                                                const Eigen::Vector3d& p1,
                                                const Eigen::Vector3d& q0,
                                                const Eigen::Vector3d& q1);

/// True only if the plane of one of the triangles shows that they are farther apart than
/// `distance`: a first look at a tenth of the cost, where only near ones matter.
[[nodiscard]] bool planeShowsFarther(const TriangleCorners& a,
                                     const TriangleCorners& b,
                                     double distance);
}  // namespace bullet_ccd
