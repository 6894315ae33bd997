/// The question that grasp_forces.h answers, and its matrices in numbers about 1 in size.
#pragma once

#include "grasp/force/contact_models.h"

#include <limits>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
struct ForceProblem
{
    std::vector<GraspContact> contacts;
    ContactLaw law{};
    Wrench load = Wrench::Zero();  ///< on the object: force [N], moment about `reference` [N m], W
    Eigen::Vector3d reference = Eigen::Vector3d::Zero();  ///< W [m]
    /// As handJacobian() returns it, 6k x q; empty: no joint limits.
    Eigen::MatrixXd jacobian{};
    Eigen::VectorXd torqueLimits{};         ///< q; infinity: none [N m or N]
    std::vector<std::string> jointNames{};  ///< q, for reasons; empty: numbers
    double maxNormalForce = std::numeric_limits<double>::infinity();  ///< of each contact [N]

    [[nodiscard]] bool hasLimits() const;
};

/// Throws std::invalid_argument "<what, which one, value>: <remedy>" unless the contacts are valid,
/// all numbers are finite, limits positive, and sizes agree.
void requireValid(const ForceProblem& problem);

/// Forces in units of `force`, lengths in units of `length`; unknowns are the local coordinates of
/// all contacts, contact by contact, `coordinates` each.
struct ScaledProblem
{
    ContactLaw law;       ///< simplified, torsion in units of `length`
    double force = 1.0;   ///< [N]
    double length = 1.0;  ///< [m]
    Eigen::Index coordinates = 0;
    Eigen::MatrixXd graspMap;   ///< 6 x n: wrench on the object
    Wrench target;              ///< -load: what graspMap times the forces must be
    Eigen::MatrixXd torqueMap;  ///< l x n: torques of the limited joints; each row over its size ..
    Eigen::VectorXd torqueLimits;             ///< .. and its limit over the same
    Eigen::VectorXd torqueScales;             ///< that size: torque = scale * row . forces [N m]
    std::vector<Eigen::Index> limitedJoints;  ///< columns of the Jacobian
    double maxNormalForce = 0.0;              ///< infinity: none
};
/// @pre the problem is valid and has contacts
[[nodiscard]] ScaledProblem scaled(const ForceProblem& problem);

/// J^T f for the local forces of all contacts [N, N m], one entry a column of the Jacobian.
/// @param local  contacts in columns, coordinates of `law` (simplified)
[[nodiscard]] Eigen::VectorXd jointTorques(const ForceProblem& problem,
                                           const ContactLaw& law,
                                           const Eigen::MatrixXd& local);
}  // namespace bullet_ccd::grasp
