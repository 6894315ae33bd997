/// A grasp in three dimensions, for any viewer.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <filesystem>
#include <span>

namespace bullet_ccd::grasp
{
/// Writes binary glTF 2.0 (.glb), metres. The root node "grasp" turns the object's mesh frame W,
/// z up, to glTF's y up; all below it is in W:
///   "hand"            one node a link with geometry, named as the link
///   "object: NAME"    see-through, as in the pictures
///   "obstacles"       the bodies beside the object, see-through: "obstacle 1", ...
///   "contacts"        a ball at each contact's point: "contact 1: LINK", ...
///   "friction cones"  at each contact, the forces that the link may apply to the object: apex at
///                     the point, axis along the normal, half angle atan(friction)
///   "swept boxes"     lines about all that each link may pass through while the hand closes from
///                     its preshape (sweptBoxes()); no boxes if the hand does not have the preshape
/// Colours are those of drawGrasp().
/// @pre the grasp was closed: it has joint positions
/// Throws std::runtime_error if the file cannot be written, std::invalid_argument if `friction` is
/// not positive or there are no joint positions.
BULLET_CCD_API void writeGraspModel(const HandModel& hand,
                                    const GraspObject& object,
                                    const Grasp& grasp,
                                    double friction,
                                    const std::filesystem::path& file,
                                    std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::grasp
