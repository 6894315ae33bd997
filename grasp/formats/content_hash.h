/// Names of hands and objects by their content, so that a result can tell that they changed.
#pragma once

#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp.h"
#include "grasp/hand/hand_model.h"

#include <span>
#include <string>

namespace bullet_ccd::grasp
{
/// Hash of everything about a hand that planning depends on: kinematics, meshes, closing
/// directions, preshapes, grasp frame. 16 hexadecimal digits.
[[nodiscard]] std::string contentHash(const HandModel& hand);
/// Hash of the object's mesh, 16 hexadecimal digits.
[[nodiscard]] std::string contentHash(const GraspObject& object);
/// Hash of the meshes and poses of bodies at rest, 16 hexadecimal digits; empty if there are none.
[[nodiscard]] std::string contentHash(std::span<const RigidBody> obstacles);
}  // namespace bullet_ccd::grasp
