/// Meshes made by formula: the inputs of tests, benchmarks, URDF primitives and generated robots.
/// All are closed, wound outwards, centred as stated, in metres.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "bullet_ccd/mesh/triangle_mesh.h"

namespace bullet_ccd
{
/// Box centred at the origin; 12 triangles.
[[nodiscard]] TriangleMesh makeBox(const Eigen::Vector3d& halfExtents);

/// Sphere centred at the origin, vertices on the sphere (inscribed), 20 * 4^subdivisions triangles.
[[nodiscard]] TriangleMesh makeSphere(double radius, int subdivisions);

/// Cylinder about z, centred; `segments` vertices a ring on the circle (inscribed).
[[nodiscard]] TriangleMesh makeCylinder(double radius, double height, int segments);

/// Capsule about z, centred; `height` is the distance of the two sphere centres.
[[nodiscard]] TriangleMesh makeCapsule(double radius, double height, int segments);

/// Torus about z.
[[nodiscard]] TriangleMesh makeTorus(double majorRadius, double minorRadius, int majorSegments,
                                     int minorSegments);

/// Solid of revolution about z from a closed profile of (radius, z) points with radius >= 0, listed
/// counter-clockwise in the half plane (r to the right, z up), so that the surface is wound outwards.
/// Points on the axis become poles. `segments` >= 3.
[[nodiscard]] TriangleMesh makeRevolved(const std::vector<Eigen::Vector2d>& profile, int segments);

/// Closed tube: cross-section `section(u)` is a ring of points (same count for all u, counter-
/// clockwise seen from its end), stacked over `rings` stations and capped flat at both ends.
[[nodiscard]] TriangleMesh makeLofted(
    const std::function<std::vector<Eigen::Vector3d>(int station)>& section, int stations);

/// A single triangle: the smallest polygon soup.
[[nodiscard]] TriangleMesh makeTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        const Eigen::Vector3d& c);
}  // namespace bullet_ccd
