/// Reads mesh files. OBJ and OFF are read by this library. STL (text and binary), PLY, DAE, glTF
/// and GLB are read by assimp in a process of its own, the program bullet_ccd_mesh_reader. The
/// program is installed with the library; if it is not found, set the environment variable
/// BULLET_CCD_MESH_READER to its path. The processor time and memory of the program are limited per
/// MiB of the file; wall time is not limited. All functions may be called from several threads.
///
/// Coordinates of OBJ and OFF files become the nearest doubles. Assimp stores single precision, so
/// coordinates of the other formats are rounded to 24 bits (6e-8 of their size). Binary STL, glTF
/// and most PLY files hold no more than that.
///
/// Numbers are metres after `MeshFileOptions::scale`. DAE is read as RViz and MoveIt do:
/// <unit meter=".."/> is applied, and <up_axis> is ignored. glTF keeps its axes (y up), too. Node
/// transforms are applied.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd
{
/// How a mesh file is read.
struct MeshFileOptions
{
    double scale = 1.0;  ///< file units to metres; finite and > 0
};

/// The content of a mesh file.
struct MeshFile
{
    TriangleMesh mesh;               ///< checked and repaired
    MeshRepair repair;               ///< what was repaired
    std::vector<std::string> notes;  ///< what a user should know, one line each; often empty
};

/// Extent [m] above which a note asks whether the file is in millimetres.
inline constexpr double kSuspiciousExtent = 10.0;

/// Reads all triangles of all meshes of a file. Polygons are triangulated; lines and points are
/// dropped with a note.
///
/// Guarantee: the mesh has passed checkMesh() and repairMesh().
/// Throws std::runtime_error: "<path>: <what, where, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API MeshFile loadMeshFile(const std::filesystem::path& path,
                                                   const MeshFileOptions& options = {});

/// Writes OBJ.
///
/// Guarantee: the digits give the same doubles back, so loadMeshFile() of the file is exact up to
/// repairs.
/// Throws std::runtime_error if the file cannot be written.
BULLET_CCD_API void writeObj(const TriangleMesh& mesh, const std::filesystem::path& path);
}  // namespace bullet_ccd
