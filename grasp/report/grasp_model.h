/// A grasp in three dimensions, for any viewer.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"
#include "grasp/report/raster.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

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

/// Something that moves as one piece.
struct MotionTrack
{
    std::string name;
    const SsvTree* tree = nullptr;
    Color color = Color::Zero();
    std::vector<Eigen::Isometry3d> poses;  ///< one for each time, or a single one: it is at rest
    std::string kind{};                    ///< of pages: what is shown and hidden together
};

/// Writes an animation as binary glTF 2.0 (.glb), metres and seconds: below the node `root`, which
/// turns z up to glTF's y up, one node a track. Tracks of one colour share a material.
/// Throws std::runtime_error if the file cannot be written.
BULLET_CCD_API void writeMotionModel(const std::string& root,
                                     std::span<const float> times,
                                     std::span<const MotionTrack> tracks,
                                     const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
