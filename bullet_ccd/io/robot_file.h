/// Reads robots from URDF, xacro or MJCF, whichever a file is.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/io/urdf_file.h"

#include <filesystem>

namespace bullet_ccd
{
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
///   actuator, mimics that one. A joint that an equality holds at a constant is fixed.
/// - <default>, class and childclass, <include>, <frame>, all orientations, `fromto`, and the
///   compiler's angle, eulerseq, directories and autolimits are obeyed.
/// What is not understood is left out and named in a note: planes and height fields, loops
/// (connect, weld), spatial tendons, composites, replicates and attached models.
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadMjcf(const std::filesystem::path& path);

/// Reads a robot from URDF, xacro or MJCF; the content says which. xacro is expanded by the program
/// of that name, which has to be on the PATH.
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API RobotModel loadRobot(const std::filesystem::path& path);
}  // namespace bullet_ccd
