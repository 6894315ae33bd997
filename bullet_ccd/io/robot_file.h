/// Reads robots from URDF, xacro or MJCF, whichever a file is, into kinematic trees with collision
/// meshes, and writes URDF.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd
{
/// A robot as its file describes it.
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

/// Reads a robot from URDF, by urdfdom.
///
/// Joints may be revolute, continuous, prismatic or fixed, with limits. A chain of mimic joints is
/// resolved to the joint that drives it. An inertial that is missing or not physical is computed
/// from the mesh at 1000 kg/m^3 and noted. A link may have several collision elements: meshes, with
/// any scale, also a negative one, boxes, spheres and cylinders. A mesh path may be absolute, start
/// with file://, or be relative to the URDF. A package:// is looked up in the URDF's folder, its
/// parents and ROS_PACKAGE_PATH.
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadUrdf(const std::filesystem::path& path);

/// Reads a robot from MJCF, the files of MuJoCo, as its Menagerie writes them.
///
/// Bodies become links, joints keep their names, and joint positions are MuJoCo's (`ref` included).
/// - The root link is the only body below the world; a free joint and the body's pose in the world
///   are left out, as are the geoms of the world. Bodies with a free joint beside other trees are
///   objects and left out. If several bodies stay, or the only one has a joint, the root is a link
///   "world".
/// - A joint turns about the origin of its link: if its `pos` is not 0, the link's frame is moved
///   there from the body's. A body with several joints gets a link <body>/<joint> without geometry
///   for all joints but the last.
/// - Geometry is that of geoms that can collide (contype or conaffinity is not 0). Meshes stay as
///   they are, where MuJoCo takes their convex hulls.
/// - Inertials are those of the file, else those of the body's geoms by their masses or densities.
/// - Efforts are the least of the force ranges of a joint and its actuators (gear and coefficients
///   of tendons included; a motor has its control range).
/// - A joint whose position an equality gives from another one, or that shares the tendon of an
///   actuator, mimics that one. A joint that an equality holds at a constant is fixed, and so are
///   those that follow it.
/// - <default>, class and childclass, <include>, <frame>, all orientations, `fromto`, and the
///   compiler's angle, eulerseq, directories and autolimits are obeyed.
/// What is not understood is left out and named in a note, with its line: planes and height fields,
/// loops (connect, weld), spatial tendons, composites, replicates and attached models, and elements
/// and attributes that MJCF does not have. Names of joints and tendons that nothing has, and ranges
/// that are turned round, are errors.
/// Throws std::runtime_error: "<file>:<line>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadMjcf(const std::filesystem::path& path);

/// Writes a robot as URDF, with the mesh of each link as <stem>_meshes/<number>.obj beside it.
///
/// loadUrdf() reads the same robot from it: kinematics to rounding, meshes up to the digits that
/// writeObj() writes. Limits beyond a million, which sliding joints may not have, become that;
/// joints without a name get that of their link with "_joint" behind it. Folders must exist.
/// Throws std::runtime_error if a file cannot be written, and for spherical joints.
BULLET_CCD_API void writeUrdf(const RobotModel& robot, const std::filesystem::path& path);

/// Reads a robot from URDF, xacro or MJCF; the content says which. xacro is expanded by the program
/// of that name, which has to be on the PATH. It evaluates the Python expressions of the file and
/// has no time limit: give it files that you trust.
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadRobot(const std::filesystem::path& path);
}  // namespace bullet_ccd
