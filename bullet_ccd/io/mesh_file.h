/// Mesh files to TriangleMesh: OBJ and OFF by readers of our own, STL (text and binary), PLY, DAE,
/// glTF and GLB by assimp, in a process of its own (the program bullet_ccd_mesh_reader, which is
/// installed with the library; set the environment variable BULLET_CCD_MESH_READER to its path
/// where it is not found). Reading is limited by processor time and memory per MiB of the file,
/// never by wall time. Safe to call from several threads.
///
/// Coordinates. OBJ and OFF numbers become the nearest double. Assimp stores single precision:
/// coordinates of the other formats are rounded to 24 bits when they are read (6e-8 of their size),
/// which is all that binary STL, glTF and most PLY files hold anyway.
///
/// Units and axes. Numbers are metres after `MeshFileOptions::scale`. DAE is read as RViz and
/// MoveIt do: <unit meter=".."/> is applied, <up_axis> is ignored. glTF keeps its axes too (y up):
/// nothing is turned. Node transforms are applied.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd
{
struct MeshFileOptions
{
    double scale = 1.0;  ///< file units to metres; finite and > 0
};

struct MeshFile
{
    TriangleMesh mesh;               ///< checked and repaired
    MeshRepair repair;               ///< what was repaired
    std::vector<std::string> notes;  ///< one line for everything a user should know; often empty
};

/// Extent above which a note asks whether the file is in millimetres [m].
inline constexpr double kSuspiciousExtent = 10.0;

/// Reads all triangles of all meshes of a file; polygons are triangulated, lines and points dropped
/// with a note. Then checkMesh() and repairMesh().
/// Throws std::runtime_error: "<path>: <what, where, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API MeshFile loadMeshFile(const std::filesystem::path& path,
                                                   const MeshFileOptions& options = {});

/// Writes OBJ (text, shortest digits that give the same doubles back: loadMeshFile() of the file is
/// exact up to repairs). Throws std::runtime_error.
BULLET_CCD_API void writeObj(const TriangleMesh& mesh, const std::filesystem::path& path);
}  // namespace bullet_ccd
