/// How the joints of a hand move the contact points on its links, and which torques the contacts
/// need: tau = J^T f.
///
/// Only independent joints count. A mimic joint moves with the joint that it follows, so its
/// motion, times its multiplier, is added to the motion of that joint.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/grasp_types.h"

#include <Eigen/Geometry>

#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// Movable joints that follow no other joint, as ascending indices of the links below them.
/// Throws std::invalid_argument for a spherical joint, which has no single torque.
[[nodiscard]] BULLET_CCD_API std::vector<std::int32_t> independentJoints(const KinematicTree& tree);

/// One twist per independent joint and contact, joint by joint. A twist is the velocity of the
/// link's point at the contact [m/s] and the angular velocity of the link [rad/s], both in W, for a
/// speed of the joint of 1 rad/s or 1 m/s. For k contacts and q joints the result is in memory a
/// matrix of 6k rows and q columns, stored column by column.
/// @param X_WH       pose of the root link
/// @param positions  one entry per link, mimics applied [rad or m]
/// Throws std::invalid_argument for a contact of a link that does not exist.
[[nodiscard]] BULLET_CCD_API std::vector<Twist> handJacobian(
    const KinematicTree& tree,
    const Eigen::Isometry3d& X_WH,
    std::span<const double> positions,
    std::span<const GraspContact> contacts);

/// Effort limits of the independent joints [N m or N]; infinity where the robot states none. A
/// mimic joint has no motor of its own, so its limit does not count.
[[nodiscard]] BULLET_CCD_API std::vector<double> effortLimits(const KinematicTree& tree);
}  // namespace bullet_ccd::grasp
