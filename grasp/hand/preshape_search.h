/// Finds what a hand does with the joints that do not close it: turning a thumb into opposition,
/// spreading fingers.
#pragma once

#include "grasp/hand/hand_model.h"

#include <optional>
#include <vector>

namespace bullet_ccd::grasp
{
/// Preshapes for different tasks, the one that is best over all first, at most three. They are
/// named after the tasks that they are best at (wrap, precision, lateral, spread), or "open" if
/// there is one only. Nothing if the hand has no joint to search, or overlaps itself everywhere.
///
/// Searched are the joints below the palm that do not close, how far the fingers are bent, and the
/// grasp frame. A posture is judged by trial grasps of balls, bars and plates (trial_grasps.h). The
/// same hand gets the same preshapes. No preshape overlaps itself, except where the open hand does
/// so with those joints at 0.
/// @param frame of all preshapes in the root link, if it is known: they get none of their own
/// @pre `fingers`, `palm` and `closingDirections` are set
[[nodiscard]] BULLET_CCD_API std::optional<std::vector<Preshape>> searchPreshapes(
    const HandModel& hand, const std::optional<Eigen::Isometry3d>& frame);

/// The grasp frame of these positions (one entry per link [rad or m]): inferGraspFrame(), improved
/// by trial grasps if the hand has joints that searchPreshapes() would search.
[[nodiscard]] Eigen::Isometry3d searchGraspFrame(const HandModel& hand,
                                                 const std::vector<double>& positions);

/// Ratios of closing speeds, one entry per link (HandModel::closingSpeeds): a joint with k others
/// above it in its finger that close by themselves, too, closes with the k-th power of a ratio, so
/// that fingers reach round an object before their ends curl. The ratio is the one of a few with
/// which trial grasps from the hand's preshapes hold most. Empty if that is 1, or if no finger has
/// two such joints.
/// @pre `preshapes` and their grasp frames are set, as well
[[nodiscard]] BULLET_CCD_API std::vector<double> searchClosingSpeeds(const HandModel& hand);
}  // namespace bullet_ccd::grasp
