/// Where the hand is when a trial begins. Internal to this room.
#pragma once

#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"
#include "grasp/trial/protocol.h"

#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
struct TrialPosture
{
    std::string blocked;  ///< why the hand gets nowhere; else empty
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< of the root link
    std::vector<double> positions;                           ///< one entry per link [rad or m]
};

/// The closed posture, drawn back and opened until no link is within `clearance` [m] of the object
/// where that takes a few clearances at most, else as far as it goes without touching it.
[[nodiscard]] TrialPosture heldStart(const HandModel& hand,
                                     const GraspObject& object,
                                     const Grasp& grasp,
                                     double clearance);

/// The open hand at the end of its approach, off by the protocol's error, and drawn back by the
/// clearance. The direction of the error follows from the seed and the number of the candidate.
/// Blocked, too, where the protocol has a table, which is a clearance below the object along `up`,
/// a unit vector, and the hand would be in it there, or in the posture of the grasp.
/// Throws std::invalid_argument if the hand has no preshape of the grasp's name.
[[nodiscard]] TrialPosture openStart(const HandModel& hand,
                                     const GraspObject& object,
                                     const Grasp& grasp,
                                     const TrialProtocol& protocol,
                                     std::uint64_t seed,
                                     double clearance,
                                     const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());
}  // namespace bullet_ccd::grasp
