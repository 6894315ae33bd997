/// How the joints of a hand move the contact points on its links, and which torques contacts ask
/// for.
///
/// Columns belong to independent joints only: a mimic joint moves with the joint that it follows,
/// and what it does is summed into that column, times its multiplier. Torque of a joint: tau = J^T
/// f.
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/force/contact_models.h"

#include <Eigen/Geometry>

#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// Movable joints that follow no other, as indices of the links below them, ascending.
/// Throws std::invalid_argument for a spherical joint: it has no single torque.
[[nodiscard]] std::vector<std::int32_t> independentJoints(const KinematicTree& tree);

/// Six rows a contact: velocity of the link's point there [m/s] and angular velocity of the link
/// [rad/s], both in W; one column an independent joint, per rad/s or m/s of it.
/// @param X_WH       pose of the root link
/// @param positions  one entry a link, mimics applied [rad or m]
/// Throws std::invalid_argument for a contact of a link that does not exist.
[[nodiscard]] Eigen::MatrixXd handJacobian(const KinematicTree& tree,
                                           const Eigen::Isometry3d& X_WH,
                                           std::span<const double> positions,
                                           std::span<const GraspContact> contacts);

/// Effort limits of the independent joints [N m or N]; infinity where the robot names none. A mimic
/// joint has no motor of its own: its limit plays no part.
[[nodiscard]] Eigen::VectorXd effortLimits(const KinematicTree& tree);
}  // namespace bullet_ccd::grasp
