/// Meshes made by formula: the inputs of tests, benchmarks, URDF primitives and generated robots.
///
/// Guarantee: all meshes except that of makeTriangle() are closed and wound outwards. Lengths are
/// in metres. All functions throw std::invalid_argument for sizes that make no solid (lengths that
/// are not positive, too few segments).
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace bullet_ccd
{
/// Box centred at the origin, of 12 triangles.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeBox(const Eigen::Vector3d& halfExtents);

/// Inscribed sphere centred at the origin, of 20 * 4^subdivisions triangles. Its vertices are on
/// the sphere.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeSphere(double radius, int subdivisions);

/// Inscribed cylinder about z, centred at the origin, with `segments` vertices per ring.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeCylinder(double radius, double height, int segments);

/// Capsule about z, centred at the origin. `height` is the distance of the two sphere centres.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeCapsule(double radius, double height, int segments);

/// Torus about z, centred at the origin.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeTorus(double majorRadius,
                                                    double minorRadius,
                                                    int majorSegments,
                                                    int minorSegments);

/// Solid of revolution about z. The closed profile is a list of (radius, z) points with radius >=
/// 0, counter-clockwise in the half plane (r to the right, z up), so that the surface is wound
/// outwards. Points on the axis become poles. An edge along the axis closes the profile and makes
/// no surface. `segments` is at least 3.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeRevolved(const std::vector<Eigen::Vector2d>& profile,
                                                       int segments);

/// Closed tube over `stations` >= 2 stations. The cross-section `section(u)` at station u is a ring
/// of points, counter-clockwise seen from the end of the tube; all rings have the same number of
/// points. Both ends are capped by fans about the mean of their ring. A ring whose points all
/// coincide becomes a pole.
[[nodiscard]] BULLET_CCD_API TriangleMesh
makeLofted(const std::function<std::vector<Eigen::Vector3d>(int station)>& section, int stations);

/// A single triangle, the smallest polygon soup.
[[nodiscard]] BULLET_CCD_API TriangleMesh makeTriangle(const Eigen::Vector3d& a,
                                                       const Eigen::Vector3d& b,
                                                       const Eigen::Vector3d& c);
}  // namespace bullet_ccd
