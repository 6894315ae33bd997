/// Names of hands and objects by their content, so that a result can tell that they changed.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <span>
#include <string>

namespace bullet_ccd::grasp
{
/// Hash of everything about a hand that planning depends on: kinematics, meshes, closing
/// directions, preshapes, grasp frame. 16 hexadecimal digits.
[[nodiscard]] BULLET_CCD_API std::string contentHash(const HandModel& hand);
/// Hash of the object's mesh, 16 hexadecimal digits.
[[nodiscard]] BULLET_CCD_API std::string contentHash(const GraspObject& object);
/// Hash of the meshes and poses of bodies at rest, 16 hexadecimal digits; empty if there are none.
[[nodiscard]] BULLET_CCD_API std::string contentHash(std::span<const RigidBody> obstacles);
}  // namespace bullet_ccd::grasp
