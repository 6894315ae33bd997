/// Convex hulls as meshes.
#ifndef BT_CCD_HULL_MESH_H
#define BT_CCD_HULL_MESH_H

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <vector>

/// Surface of the convex hull of the points, wound outwards; its vertices are points of the input.
/// No point lies more than 1e-9 of the size of the hull outside. Points that do not span a volume
/// give one degenerate triangle (a point, a segment) or a polygon of either orientation.
///
/// Bullet's own btConvexHullComputer works on coordinates rounded to 1e-4 of the size of the hull,
/// which is more than the tolerance of a time of impact.
///
/// Throws std::invalid_argument without points, or for one that is not finite.
bullet_ccd::TriangleMesh btCcdHullMesh(const std::vector<Eigen::Vector3d>& points);

#endif  // BT_CCD_HULL_MESH_H
