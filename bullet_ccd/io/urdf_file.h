/// URDF files to kinematic trees with collision meshes, by urdfdom.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd
{
struct RobotModel
{
    std::string name;
    std::filesystem::path file;
    KinematicTree tree;
    /// One entry a link, link frame [m]: all collision elements in one mesh; empty if there are
    /// none.
    std::vector<TriangleMesh> linkMeshes;
    std::vector<std::string> notes;  ///< what was assumed or repaired, one line each
};

/// Chord error allowed when a sphere or cylinder of a URDF becomes triangles [m].
inline constexpr double kPrimitiveChordError = 5e-5;

/// Reads a robot: revolute, continuous, prismatic and fixed joints, limits, mimics (chains of
/// mimics resolved to the joint that drives them), inertials (computed from the mesh at 1000 kg/m^3
/// where missing or not physical, and noted), collision geometry (several a link; mesh with scale,
/// also negative; box, sphere, cylinder). Mesh paths: file://, absolute, relative to the URDF, or
/// package:// looked up in the URDF's folder, its parents, and ROS_PACKAGE_PATH.
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadUrdf(const std::filesystem::path& path);
}  // namespace bullet_ccd
