/// Solid -> closed triangle mesh.
///
/// Marching tetrahedra on a fine grid (six tetrahedra a cube) give a surface that is closed and
/// two-manifold by construction, but full of slivers. Remeshing then collapses short edges, turns
/// edges and slides vertices along the surface until edges have the length that the curvature asks
/// for; every step keeps the mesh closed and manifold and every vertex on the solid's surface.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "robots/shapes/solid.h"

#include <Eigen/Geometry>

namespace bullet_ccd::shapes
{
struct PolygonizeOptions
{
    double cell = 1.8e-3;          ///< grid spacing, less than the thinnest wall [m]
    double chordError = 1.5e-4;    ///< aim for the distance of triangles from a curved surface [m]
    double shortestEdge = 2.0e-3;  ///< edges are not made shorter than this for curvature [m]
    double longestEdge = 1.2e-2;   ///< nor longer than this where the surface is flat [m]
};

/// Surface of `solid` within `box` (which must contain it), wound outwards. Deterministic.
/// Throws std::runtime_error if the result is not watertight: the solid leaves the box.
[[nodiscard]] TriangleMesh polygonize(const Solid& solid,
                                      const Eigen::AlignedBox3d& box,
                                      const PolygonizeOptions& options = {});
}  // namespace bullet_ccd::shapes
