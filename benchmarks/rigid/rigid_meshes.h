/// Meshes of the rigid benchmarks: families with a resolution, the same vertices on every machine.
/// Lengths are in model units (the bunny of the file sets is 156 wide).
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

namespace bullet_ccd::benchmarks
{
/// Tube along a (2, 3) torus knot; 2 * along * around triangles.
[[nodiscard]] TriangleMesh makeKnotTube(int along, int around);

/// Subdivided icosahedron of the given radius, 20 * 4^subdivisions triangles; `amplitude` > 0 lets
/// the radius wave by that fraction.
[[nodiscard]] TriangleMesh makeBumpySphere(int subdivisions, double radius, double amplitude);

/// Capsule along z whose lower cap is centred at the origin, the joint; 928 triangles.
[[nodiscard]] TriangleMesh makeFinger();

/// Closed box centred at the origin with so many cells along each axis.
[[nodiscard]] TriangleMesh makeGridBox(const std::array<int, 3>& cells,
                                       const Eigen::Vector3d& halfExtents);

/// Closed cylinder about z, centred at the origin, with rings of triangles on its caps and along
/// its height.
[[nodiscard]] TriangleMesh makeRingedCylinder(
    double radius, double height, int segments, int ringsOnCap, int ringsAlong);
}  // namespace bullet_ccd::benchmarks
