/// Meshes made by formula: the inputs of tests, benchmarks, URDF primitives and generated robots.
/// All (but makeTriangle) are closed, wound outwards, centred as stated, in metres. Sizes that make
/// no solid (not positive, too few segments) throw std::invalid_argument.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace bullet_ccd
{
/// Box centred at the origin; 12 triangles.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeBox(const Eigen::Vector3d& halfExtents);

/// Sphere centred at the origin, vertices on the sphere (inscribed), 20 * 4^subdivisions triangles.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeSphere(double radius, int subdivisions);

/// Cylinder about z, centred; `segments` vertices a ring on the circle (inscribed).
[[nodiscard]] BULLET_CCD_API TriangleMesh makeCylinder(double radius, double height, int segments);

/// Capsule about z, centred; `height` is the distance of the two sphere centres.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeCapsule(double radius, double height, int segments);

/// Torus about z.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeTorus(double majorRadius,
                                                    double minorRadius,
                                                    int majorSegments,
                                                    int minorSegments);

/// Solid of revolution about z from a closed profile of (radius, z) points with radius >= 0, listed
/// counter-clockwise in the half plane (r to the right, z up), so that the surface is wound
/// outwards. Points on the axis become poles; an edge along the axis closes the profile and makes
/// no surface. `segments` >= 3.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeRevolved(const std::vector<Eigen::Vector2d>& profile,
                                                       int segments);

/// Closed tube: cross-section `section(u)` is a ring of points (same count for all u, counter-
/// clockwise seen from its end), stacked over `stations` >= 2 stations and capped flat at both
/// ends. Caps are fans about the mean of their ring; a ring whose points all coincide becomes a
/// pole.
[[nodiscard]] BULLET_CCD_API TriangleMesh
makeLofted(const std::function<std::vector<Eigen::Vector3d>(int station)>& section, int stations);

/// A single triangle: the smallest polygon soup.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeTriangle(const Eigen::Vector3d& a,
                                                       const Eigen::Vector3d& b,
                                                       const Eigen::Vector3d& c);
}  // namespace bullet_ccd
