/// The problem of grasp_forces.h as matrices of numbers about 1 in size.
#pragma once

#include "grasp/force/contact_models.h"
#include "grasp/force/grasp_forces.h"

#include <vector>

namespace bullet_ccd::grasp
{
/// The Jacobian as a matrix, 6k x q.
[[nodiscard]] inline Eigen::Map<const Eigen::MatrixXd> jacobianOf(const ForceProblem& problem)
{
    return {problem.jacobian.empty() ? nullptr : problem.jacobian.front().data(),
            6 * static_cast<Eigen::Index>(problem.contacts.size()),
            static_cast<Eigen::Index>(problem.torqueLimits.size())};
}

/// Numbers of the interface as a vector.
[[nodiscard]] inline Eigen::Map<const Eigen::VectorXd> vectorOf(const std::vector<double>& numbers)
{
    return {numbers.data(), static_cast<Eigen::Index>(numbers.size())};
}

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
