/// Meshes of the rigid benchmarks: families with a resolution, the same vertices on every machine.
/// Lengths are in model units (the bunny of the file sets is 156 wide).
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

namespace bullet_ccd::benchmarks
{
/// Of the bodies of the sets worst_*, which fit into each other.
constexpr double kGearBacklash = 0.04;
constexpr double kBall = 60.0;
constexpr double kBolt = 40.0;
constexpr double kThread = 3.6;
constexpr double kPitch = 12.0;
constexpr double kNutClearance = 0.4;
constexpr double kCombPitch = 4.0;
constexpr double kBlade = 0.9;  ///< half of its thickness

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

/// Spur gear about z with involute teeth at 20 degrees, whose flanks are narrower by `backlash` at
/// the pitch circle (all lengths in modules: a pitch radius of teeth / 2).
[[nodiscard]] TriangleMesh makeGear(int teeth, double backlash, double width, int stations);

/// Rounded thread about z of that radius, depth and pitch; `isNut` leaves out its ends.
[[nodiscard]] TriangleMesh makeThread(double radius, double depth, double pitch, bool isNut);

/// Parallel blades, `pitch` apart along z, without a back.
[[nodiscard]] TriangleMesh makeComb(int blades, double pitch, const Eigen::Vector3d& halfExtents);
}  // namespace bullet_ccd::benchmarks
