/// What a hand is like when nobody says: fingers, closing directions, preshape and grasp frame from
/// the kinematics and the link meshes alone. Every function is a heuristic; the caller notes its
/// use.
#pragma once

#include "bullet_ccd/io/robot_file.h"
#include "grasp/hand/hand_model.h"

#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// Chains that end in a link with geometry and have a movable joint that no longer chain shares;
/// named after their tip links. Links are those of no other finger.
[[nodiscard]] std::vector<Finger> inferFingers(const RobotModel& robot, std::int32_t& palm);

/// Deepest link above all the fingers given by their tips.
/// Also strips from each finger the links that it shares with another one, and those of the palm.
[[nodiscard]] std::int32_t palmAbove(const KinematicTree& tree, std::vector<Finger>& fingers);

/// Centre of the bounding box of the last link of the finger that has geometry, root frame.
[[nodiscard]] Eigen::Vector3d fingertip(const RobotModel& robot,
                                        const Finger& finger,
                                        const std::vector<Eigen::Isometry3d>& poses);

/// One entry a link: +1 or -1 for the joints whose axes are parallel, within 25 degrees and with
/// driving joints at zero, to the last joint of their finger; 0 for joints that spread or turn it,
/// are not part of a finger, mimic another one, or are passive. The joints of a finger turn the
/// same way about their common axis: the way that brings its tip nearer to a point between the
/// fingertips and the palm or, if both ways do so alike, the way in which they have more range.
[[nodiscard]] std::vector<int> inferClosingDirections(const HandModel& hand,
                                                      const std::vector<bool>& isPassive);

/// Closing joints at their opening limit, but no more than 20 degrees beyond zero; others at zero,
/// clamped.
[[nodiscard]] Preshape inferPreshape(const HandModel& hand);

/// Openings of jaws on one motor besides `open`, widest first: `half` and `near`, a half and a
/// quarter of the way from closed. None for other hands, or if the jaws have no limit.
[[nodiscard]] std::vector<Preshape> inferOpenings(const HandModel& hand, const Preshape& open);

/// Between the fingertips of a hand that is half closed from `open`, x from the finger that opposes
/// the others to them, z away from the palm.
[[nodiscard]] Eigen::Isometry3d inferGraspFrame(const HandModel& hand,
                                                const std::vector<double>& open);

/// `q` within the limits of the joint.
[[nodiscard]] double clampToLimits(const Joint& joint, double q);
}  // namespace bullet_ccd::grasp
