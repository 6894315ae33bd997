/// Link meshes of the robots that ship, in the link frames of robots/<name>/<name>.urdf [m].
/// Finger links: joint at the origin, bone along +z, palmar side +x.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <string>
#include <vector>

namespace bullet_ccd::shapes
{
struct NamedMesh
{
    std::string name;  ///< file name without extension
    TriangleMesh mesh;
};

struct RobotMeshes
{
    std::string robot;
    std::vector<NamedMesh> links;
};

[[nodiscard]] RobotMeshes anthropomorphicHandMeshes();
[[nodiscard]] RobotMeshes threeFingerGripperMeshes();
[[nodiscard]] RobotMeshes parallelGripperMeshes();
}  // namespace bullet_ccd::shapes
