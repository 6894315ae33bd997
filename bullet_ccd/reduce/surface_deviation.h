/// How far one surface reaches from another, as a certified number.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <limits>

namespace bullet_ccd
{
/// Bounds of the greatest distance of a point of a surface from another surface [m].
struct Deviation
{
    double lower = 0.0;                               ///< `point` is this far away
    double upper = 0.0;                               ///< no point is farther away
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< of the surface, in its frame
};

/// Greatest distance of a point of `surface` from the mesh of `other`, both in one frame: the
/// one-sided Hausdorff distance. All points of the triangles count, not only their vertices.
///
/// Guarantee: the truth is in [lower, upper] up to 1e-12 of the coordinates, and upper is at most
/// 1 % above lower or above `enough`, whichever is larger, unless a triangle of `surface` meets
/// more than 100,000 others. If the truth is found to exceed `limit`, the search ends: lower is
/// then above it and upper infinite. The result does not depend on the number of threads if it is
/// below the limit. How: the distance from one triangle is convex, so its maximum over a polygon is
/// at a corner. A triangle of `surface` is cut into polygons, each of which has one triangle of
/// `other` that is near at all of its corners. Throws std::invalid_argument for a mesh that
/// checkMesh() refuses, or for bounds that are NaN or negative.
[[nodiscard]] BULLET_CCD_API Deviation
surfaceDeviation(const TriangleMesh& surface,
                 const SsvTree& other,
                 double enough,
                 double limit = std::numeric_limits<double>::infinity());
}  // namespace bullet_ccd
