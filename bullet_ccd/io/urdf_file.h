/// Reads URDF files into kinematic trees with collision meshes, by urdfdom.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd
{
/// A robot as its URDF describes it.
struct RobotModel
{
    std::string name;
    std::filesystem::path file;
    KinematicTree tree;
    /// One mesh per link, in the link's frame [m], with all collision elements of the link; empty
    /// if it has none.
    std::vector<TriangleMesh> linkMeshes;
    std::vector<std::string> notes;  ///< what was assumed or repaired, one line each
};

/// Largest chord error [m] when a sphere or cylinder of a URDF becomes triangles.
inline constexpr double kPrimitiveChordError = 5e-5;

/// Reads a robot.
///
/// Joints may be revolute, continuous, prismatic or fixed, with limits. A chain of mimic joints is
/// resolved to the joint that drives it. An inertial that is missing or not physical is computed
/// from the mesh at 1000 kg/m^3 and noted. A link may have several collision elements: meshes, with
/// any scale, also a negative one, boxes, spheres and cylinders. A mesh path may be absolute, start
/// with file://, or be relative to the URDF. A package:// is looked up in the URDF's folder, its
/// parents and ROS_PACKAGE_PATH.
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadUrdf(const std::filesystem::path& path);
}  // namespace bullet_ccd
