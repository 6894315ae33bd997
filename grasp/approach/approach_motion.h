/// The approach: the hand moves without closing until its first contact.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/hand/hand_model.h"

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// First contact of any link with the environment while the hand moves along `shift` (W [m]) from
/// X_WH, with its joints at rest. A hit leaves about half the tolerance as gap, so that closing can
/// go on from there.
///
/// Guarantee: as that of articulatedToi().
/// @param X_WH      pose of the root link
/// @param positions one entry per link [rad or m]
/// @param tolerance [m]
/// Throws std::invalid_argument as articulatedToi() does.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
approachUntilContact(const HandModel& hand,
                     const Environment& environment,
                     const Eigen::Isometry3d& X_WH,
                     const std::vector<double>& positions,
                     const Eigen::Vector3d& shift,
                     double tolerance,
                     ToiWorkspace& work);

/// Where the motion of a hand along a path ended.
struct PathApproach
{
    /// Of the last leg that was begun. It is Separated or TouchingLeaving at the end of the path.
    ToiStatus status = ToiStatus::Separated;
    std::size_t leg = 0;  ///< the last leg that was begun, from 0
    double time = 1.0;    ///< certified on that leg, in [0, 1]
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< pose of the root link there
    double length = 0.0;                                     ///< way of the root link's origin [m]
    std::vector<LinkContact> contacts = {};                  ///< as of articulatedToi()
};

/// The same along a path of poses of the root link. On each leg its origin moves on a straight
/// line, and the link turns about it by the shortest arc, both at constant speed (motionBetween()).
/// Every leg is one query, and the first contact ends the motion. On a path of one pose nothing
/// moves.
/// Throws std::invalid_argument for a path without a pose, and as articulatedToi() does.
[[nodiscard]] BULLET_CCD_API PathApproach
approachUntilContact(const HandModel& hand,
                     const Environment& environment,
                     std::span<const Eigen::Isometry3d> path,
                     const std::vector<double>& positions,
                     double tolerance,
                     ToiWorkspace& work);
}  // namespace bullet_ccd::grasp
