/// The approach: the hand moves without closing until its first contact.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/hand/hand_model.h"

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// First contact of any link with the environment while the hand, joints at rest at `positions`,
/// moves along `shift` (W) from X_WH. A hit leaves about half the tolerance, so that closing can go
/// on from there. See articulatedToi() for the guarantee and what it throws.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
approachUntilContact(const HandModel& hand,
                     const Environment& environment,
                     const Eigen::Isometry3d& X_WH,
                     const std::vector<double>& positions,
                     const Eigen::Vector3d& shift,
                     double tolerance,
                     ToiWorkspace& work);

/// Where the way of a hand along a path ended.
struct PathApproach
{
    /// Of the last leg that was begun: Separated (or TouchingLeaving) at the end of the path.
    ToiStatus status = ToiStatus::Separated;
    std::size_t leg = 0;                                     ///< that leg, from 0
    double time = 1.0;                                       ///< certified on that leg, in [0, 1]
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< the root link there
    double length = 0.0;                     ///< way of the root link's origin to there [m]
    std::vector<LinkContact> contacts = {};  ///< as of articulatedToi()
};

/// The same along a path of poses of the root link: on each leg its origin moves on a straight line
/// and it turns about it by the shortest arc, both at constant speed (motionBetween()). One query a
/// leg; the first contact ends the way. A path of one pose is no way at all.
/// Throws std::invalid_argument for a path without a pose, and as articulatedToi() does.
[[nodiscard]] BULLET_CCD_API PathApproach
approachUntilContact(const HandModel& hand,
                     const Environment& environment,
                     std::span<const Eigen::Isometry3d> path,
                     const std::vector<double>& positions,
                     double tolerance,
                     ToiWorkspace& work);
}  // namespace bullet_ccd::grasp
