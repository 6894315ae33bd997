/// Joints of URDF: from urdfdom's structures to ours.
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"

#include <urdf_model/model.h>

#include <string>
#include <vector>

namespace bullet_ccd
{
/// Links and joints of a parsed URDF, parents first, children in the order of their joints' names;
/// mimics resolved, inertials left empty.
/// Throws std::runtime_error: "<file>: joint '<name>': <what, value>: <remedy>".
[[nodiscard]] KinematicTree buildTree(const urdf::ModelInterface& model,
                                      const std::string& file,
                                      std::vector<std::string>& notes);
}  // namespace bullet_ccd
