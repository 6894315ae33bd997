/// Names of hands and objects by their content, so that a result can tell that they changed.
#pragma once

#include "grasp/grasp.h"
#include "grasp/hand/hand_model.h"

#include <string>

namespace bullet_ccd::grasp
{
/// Hash of everything about a hand that planning depends on: kinematics, meshes, closing
/// directions, preshapes, grasp frame. 16 hexadecimal digits.
[[nodiscard]] std::string contentHash(const HandModel& hand);
/// Hash of the object's mesh, 16 hexadecimal digits.
[[nodiscard]] std::string contentHash(const GraspObject& object);
}  // namespace bullet_ccd::grasp
