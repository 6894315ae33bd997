/// Distance of triangles and meshes, slow and obvious: the reference of the distance queries.
///
/// Two triangles that do not intersect are closest between two edges or between a corner and a
/// face. All 15 feature pairs are minimised, all 6 edge-face intersections tested, in long double;
/// a mesh is the minimum over all pairs of triangles, of which only those are skipped whose
/// bounding balls, or projections onto some direction, are already farther apart than the best.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>

namespace bullet_ccd::reference
{
using Corners = std::array<Eigen::Vector3d, 3>;
using WideCorners = std::array<Eigen::Matrix<long double, 3, 1>, 3>;

struct OracleDistance
{
    double distance = 0.0;  ///< exactly 0 if the triangles cross
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    std::int32_t triangleA = kNone;  ///< for meshes
    std::int32_t triangleB = kNone;
};

[[nodiscard]] OracleDistance bruteForceTriangleDistance(const Corners& a, const Corners& b);
[[nodiscard]] OracleDistance bruteForceTriangleDistance(const WideCorners& a, const WideCorners& b);

/// The direction from A to B between their closest points, in double precision; zero if they meet.
[[nodiscard]] Eigen::Vector3d directionBetween(const Corners& a, const Corners& b);

/// How far apart the triangles certainly are along a unit direction (or zero) from A to B, rounding
/// included: a quick lower bound of their distance, and nearly that between their closest points.
[[nodiscard]] double gapAlong(const Eigen::Vector3d& n, const Corners& a, const Corners& b);

/// Witnesses in the frame of B.
[[nodiscard]] OracleDistance bruteForceMeshDistance(const TriangleMesh& meshA,
                                                    const TriangleMesh& meshB,
                                                    const Eigen::Isometry3d& X_BA);

/// Distance of a point from a triangle.
[[nodiscard]] double distanceToTriangle(const Eigen::Vector3d& point, const Corners& triangle);

/// Distance of a point, given in the mesh's frame, from the surface.
[[nodiscard]] double distanceToMesh(const Eigen::Vector3d& point, const TriangleMesh& mesh);

[[nodiscard]] Corners cornersOf(const TriangleMesh& mesh, std::size_t triangle);
}  // namespace bullet_ccd::reference
