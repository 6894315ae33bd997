/// Bodies of MJCF: links, joints, geometry and inertials.
#pragma once

#include "bullet_ccd/io/robot/mjcf_document.h"
#include "bullet_ccd/io/robot_file.h"

#include <vector>

namespace bullet_ccd
{
/// A robot whose joints are not yet coupled, with what couplings need to know.
struct MjcfTree
{
    RobotModel robot;
    std::vector<double> reference;  ///< `ref` of the joint above each link
};

/// Links of all bodies that belong to the robot, parents first, in the order of the file; link
/// meshes; inertials as far as the file has them. See loadMjcf().
/// Throws std::runtime_error: "<file>: <element and name>: <what, value>: <remedy>".
[[nodiscard]] MjcfTree mjcfTree(MjcfDocument& document);

/// Equalities and tendons become mimics, actuators' ranges become efforts.
void coupleMjcf(MjcfDocument& document, MjcfTree& tree);
}  // namespace bullet_ccd
