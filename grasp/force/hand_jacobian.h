/// How the joints of a hand move the contact points on its links, and which torques contacts ask
/// for.
///
/// Only independent joints count: a mimic joint moves with the joint that it follows, and what it
/// does is added to what that joint does, times its multiplier. Torque of a joint: tau = J^T
/// f.
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
/// Movable joints that follow no other, as indices of the links below them, ascending.
/// Throws std::invalid_argument for a spherical joint: it has no single torque.
[[nodiscard]] BULLET_CCD_API std::vector<std::int32_t> independentJoints(const KinematicTree& tree);

/// One twist for every independent joint and contact, joint by joint: the velocity of the link's
/// point at the contact [m/s] and the angular velocity of the link [rad/s], both in W, for a speed
/// of the joint of 1 rad/s or 1 m/s. In memory this is a matrix of 6k rows and q columns, stored
/// column by column, for k contacts and q joints.
/// @param X_WH       pose of the root link
/// @param positions  one entry a link, mimics applied [rad or m]
/// Throws std::invalid_argument for a contact of a link that does not exist.
[[nodiscard]] BULLET_CCD_API std::vector<Twist> handJacobian(
    const KinematicTree& tree,
    const Eigen::Isometry3d& X_WH,
    std::span<const double> positions,
    std::span<const GraspContact> contacts);

/// Effort limits of the independent joints [N m or N]; infinity where the robot names none. A mimic
/// joint has no motor of its own: its limit plays no part.
[[nodiscard]] BULLET_CCD_API std::vector<double> effortLimits(const KinematicTree& tree);
}  // namespace bullet_ccd::grasp
