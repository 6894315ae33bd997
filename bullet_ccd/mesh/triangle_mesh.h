/// Triangle meshes as polygon soups, and meshes made by formula. No query assumes that a mesh is a
/// manifold, oriented or closed. The functions here compute what can be known about a mesh
/// (closedness, mass, bounds).
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace bullet_ccd
{
/// The index that names nothing.
inline constexpr std::int32_t kNone = -1;

/// Indices of three vertices.
using Triangle = std::array<std::int32_t, 3>;

/// Vertices [m] and triangles. Where the mesh has an outside, triangles are wound counter-clockwise
/// as seen from there.
struct TriangleMesh
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
};

/// What repairMesh() did. Degenerate triangles are harmless to distance queries. They are removed
/// and counted because they carry no area.
struct BULLET_CCD_API MeshRepair
{
    std::int64_t degenerateTriangles = 0;   ///< removed: two equal corners or zero area
    std::int64_t duplicateTriangles = 0;    ///< removed: same three corners as an earlier triangle
    std::int64_t mergedVertices = 0;        ///< vertices that were exactly equal to an earlier one
    std::int64_t unreferencedVertices = 0;  ///< removed

    /// One line such as "merged 12 equal vertices, removed 2 degenerate triangles"; empty if
    /// nothing was done.
    [[nodiscard]] std::string summary() const;
};

/// Volume, centre of mass and inertia of the solid that a closed mesh bounds, at density 1.
struct MassProperties
{
    double volume = 0.0;                                ///< [m^3]
    Eigen::Vector3d center = Eigen::Vector3d::Zero();   ///< centre of mass, mesh frame [m]
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about `center`, mesh axes [m^5]
};

/// Throws std::invalid_argument for a mesh that no query can take: one with coordinates that are
/// NaN or infinite, with indices out of range, or without triangles. The message starts with `name`
/// and names the first offending vertex or triangle, its value and the remedy.
BULLET_CCD_API void checkMesh(const TriangleMesh& mesh, const std::string& name);

/// Merges exactly equal vertices and removes degenerate triangles, duplicate triangles and
/// unreferenced vertices. Collinear triangles with three different corners stay where they hold a
/// watertight mesh closed: without them it would lose its volume.
///
/// Guarantee: the surface as a point set is unchanged except for parts without area.
/// @pre checkMesh() passed
BULLET_CCD_API MeshRepair repairMesh(TriangleMesh& mesh);

/// True if every edge belongs to exactly two triangles that run through it in opposite directions.
/// Edges are compared by vertex index, so a triangle soup needs repairMesh() first. A mesh without
/// triangles is not watertight.
[[nodiscard]] BULLET_CCD_API bool isWatertight(const TriangleMesh& mesh);

/// Mass properties by signed tetrahedra. A mesh that is not closed, or encloses no positive volume,
/// gets those of its bounding box; isWatertight() tells whether it is closed.
[[nodiscard]] BULLET_CCD_API MassProperties massProperties(const TriangleMesh& mesh);

/// Inertia [kg m^2] of the body of massProperties() at this mass [kg], about its centre, mesh axes.
/// Finite for sheets, too: a mesh without volume counts as its flat bounding box.
[[nodiscard]] BULLET_CCD_API Eigen::Matrix3d inertiaAtMass(const TriangleMesh& mesh, double mass);

/// Axis-aligned bounds of all vertices [m].
[[nodiscard]] BULLET_CCD_API Eigen::AlignedBox3d bounds(const TriangleMesh& mesh);

/// Maps the vertices by `transform`. A mirroring transform also flips the winding, so that outward
/// stays outward.
BULLET_CCD_API void transformMesh(TriangleMesh& mesh, const Eigen::Affine3d& transform);

/// Appends the vertices and triangles of `other` to `mesh`. No vertices are merged.
BULLET_CCD_API void appendMesh(TriangleMesh& mesh, const TriangleMesh& other);

/// 64-bit FNV-1a hash of coordinates and indices. It names a mesh by its content.
[[nodiscard]] BULLET_CCD_API std::uint64_t contentHash(const TriangleMesh& mesh);

// Meshes made by formula: the inputs of tests, benchmarks, URDF primitives and generated robots.
//
// Guarantee: all of them except that of makeTriangle() are closed and wound outwards. Lengths are
// in metres. All functions throw std::invalid_argument for sizes that make no solid (lengths that
// are not positive, too few segments).

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
