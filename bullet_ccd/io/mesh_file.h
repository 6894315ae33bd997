/// Mesh files (OBJ, STL, PLY, OFF, DAE, glTF/GLB) to TriangleMesh, by assimp.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd
{
struct MeshFileOptions
{
    double scale = 1.0;  ///< file units to metres
};

struct MeshFile
{
    TriangleMesh mesh;               ///< checked and repaired
    MeshRepair repair;               ///< what was repaired
    std::vector<std::string> notes;  ///< one line for everything a user should know; often empty
};

/// Reads all triangles of all meshes of a file, node transforms applied; polygons are triangulated,
/// lines and points dropped with a note. Then checkMesh() and repairMesh().
/// Throws std::runtime_error: "<path>: <what, where, value>: <remedy>".
[[nodiscard]] MeshFile loadMeshFile(const std::filesystem::path& path,
                                    const MeshFileOptions& options = {});

/// Writes OBJ (text, 17 digits: a round trip is exact). Throws std::runtime_error.
void writeObj(const TriangleMesh& mesh, const std::filesystem::path& path);
}  // namespace bullet_ccd
