/// Grasps in Isaac Sim's and Isaac ROS' YAML format "isaac_grasp", version 1.0.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/formats/grasp_file.h"

namespace bullet_ccd::grasp
{
/// Writes the force closures among the grasps, in the order given, as grasp_0, grasp_1, ...; an
/// empty map if there are none. Of each grasp:
///   confidence                isaacConfidence() of its epsilon
///   position, orientation     of the hand's root link in the object's mesh frame [m]
///   cspace_position           final position of every joint that moves by itself [rad or m]
///   pregrasp_cspace_position  the same joints in the preshape
/// Mimic joints are left out, as in Isaac's own files: what imports the hand drives them. The
/// head names the frames and files for people; the format's readers do not rely on it.
/// Throws std::invalid_argument if a force closure has no joint positions or a preshape that the
/// hand does not have.
BULLET_CCD_API void writeIsaacGrasps(std::ostream& out,
                                     const GraspRun& run,
                                     const HandModel& hand,
                                     const GraspObject& object,
                                     std::span<const Grasp> grasps);

/// A confidence in [0, 1) that orders grasps as epsilon does: epsilon / (epsilon + 0.1), so 0 for
/// epsilon 0 and one half for 0.1. No probability of success.
[[nodiscard]] BULLET_CCD_API double isaacConfidence(double epsilon);
}  // namespace bullet_ccd::grasp
