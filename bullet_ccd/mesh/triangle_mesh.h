/// Triangle meshes as polygon soups: no manifoldness, no orientation and no closedness is assumed
/// by any query. What can be known about a mesh (closed, mass, bounds) is computed here.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace bullet_ccd
{
/// Index that names nothing.
inline constexpr std::int32_t kNone = -1;

using Triangle = std::array<std::int32_t, 3>;

/// Vertices [m] and triangles; outward counter-clockwise winding where the mesh has an outside.
struct TriangleMesh
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
};

/// What repairMesh() did. Degenerate triangles are harmless to distance queries; they are removed
/// because they carry no area, and counted.
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

/// Checks what no query can survive: coordinates that are NaN or infinite, indices out of range, no
/// triangles at all. Throws std::invalid_argument; the message starts with `name` and names the
/// first offending vertex or triangle, its value, and the remedy.
BULLET_CCD_API void checkMesh(const TriangleMesh& mesh, const std::string& name);

/// Merges exactly equal vertices, removes degenerate and duplicate triangles and unreferenced
/// vertices. The surface as a point set is unchanged except for zero-area parts. Collinear
/// triangles with three different corners stay where they hold a watertight mesh closed: without
/// them it would lose its volume.
/// @pre checkMesh() passed
BULLET_CCD_API MeshRepair repairMesh(TriangleMesh& mesh);

/// True if every edge belongs to exactly two triangles that run through it in opposite directions.
/// Edges are compared by vertex index: repairMesh() a triangle soup first. False without triangles.
[[nodiscard]] BULLET_CCD_API bool isWatertight(const TriangleMesh& mesh);

/// Mass properties by signed tetrahedra; a mesh that is not closed, or encloses no positive volume,
/// gets those of its bounding box (the caller can tell by `isWatertight`).
[[nodiscard]] BULLET_CCD_API MassProperties massProperties(const TriangleMesh& mesh);

/// Axis-aligned bounds of all vertices.
[[nodiscard]] BULLET_CCD_API Eigen::AlignedBox3d bounds(const TriangleMesh& mesh);

/// Vertices mapped by `transform`; a mirroring transform flips the winding so that outward stays
/// outward.
BULLET_CCD_API void transformMesh(TriangleMesh& mesh, const Eigen::Affine3d& transform);

/// Appends `other`, mapped by nothing, to `mesh`.
BULLET_CCD_API void appendMesh(TriangleMesh& mesh, const TriangleMesh& other);

/// 64-bit FNV-1a hash of coordinates and indices: names a mesh by its content.
[[nodiscard]] BULLET_CCD_API std::uint64_t contentHash(const TriangleMesh& mesh);
}  // namespace bullet_ccd
