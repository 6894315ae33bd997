#include "grasp/force/force_problem.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// Wrench at the contact point itself, of each local coordinate.
ContactBasis basisAtPoint(const GraspContact& contact, const ContactLaw& law)
{
    return contactBasis(contact, law, contact.point, 1.0);
}

Eigen::Index contactCount(const ForceProblem& problem)
{
    return static_cast<Eigen::Index>(problem.contacts.size());
}

/// Torques of all joints per unit of the local coordinates, q x n.
Eigen::MatrixXd torqueMap(const ForceProblem& problem, const ContactLaw& law)
{
    const Eigen::Index d = coordinateCount(law);
    const Eigen::Map<const Eigen::MatrixXd> jacobian = jacobianOf(problem);
    Eigen::MatrixXd map(jacobian.cols(), d * contactCount(problem));
    for (Eigen::Index i = 0; jacobian.cols() > 0 && i < contactCount(problem); ++i)
    {
        map.middleCols(d * i, d) = jacobian.middleRows<6>(6 * i).transpose() *
                                   basisAtPoint(problem.contacts[static_cast<std::size_t>(i)], law);
    }
    return map;
}

/// Farthest contact from the reference; 1 m where all are there.
double lengthOf(const ForceProblem& problem)
{
    double length = 0.0;
    for (const GraspContact& contact : problem.contacts)
    {
        length = std::max(length, (contact.point - problem.reference).norm());
    }
    return length > 0.0 ? length : 1.0;
}

/// The load, or without one what the limits allow.
double forceOf(const ForceProblem& problem, double length)
{
    Wrench load = problem.load;
    load.tail<3>() /= length;
    if (load.norm() > 0.0)
    {
        return load.norm();
    }
    double force = problem.maxNormalForce;
    if (!problem.torqueLimits.empty())
    {
        force = std::min(force, vectorOf(problem.torqueLimits).minCoeff() / length);
    }
    return std::isfinite(force) ? force : 1.0;
}
}  // namespace

bool ForceProblem::hasLimits() const
{
    return std::isfinite(maxNormalForce) ||
           (!torqueLimits.empty() && std::isfinite(vectorOf(torqueLimits).minCoeff()));
}

void requireValid(const ForceProblem& problem)
{
    requireValidContacts(problem.contacts);
    static_cast<void>(simplified(problem.law));
    require(problem.load.allFinite(), "load: not finite: give forces in N and moments in N m");
    require(problem.reference.allFinite(), "reference of moments: not finite: give metres");
    require(problem.maxNormalForce > 0.0,
            "largest normal force " + std::to_string(problem.maxNormalForce) +
                ": give a positive number, or infinity for none");
    const std::size_t joints = problem.torqueLimits.size();
    require(problem.jacobian.size() == joints * problem.contacts.size(),
            "Jacobian: " + std::to_string(problem.jacobian.size()) +
                " twists: give one for each of the " + std::to_string(problem.contacts.size()) +
                " contacts and each of the " + std::to_string(joints) + " torque limits");
    require(jacobianOf(problem).allFinite(), "Jacobian: not finite: check the joint positions");
    require(problem.jointNames.empty() || problem.jointNames.size() == joints,
            "joint names: give one for each torque limit, or none");
    for (std::size_t j = 0; j < joints; ++j)
    {
        require(problem.torqueLimits[j] > 0.0,
                "torque limit of joint " + std::to_string(j) + " is " +
                    std::to_string(problem.torqueLimits[j]) +
                    ": give a positive number, or infinity for none");
    }
}

ScaledProblem scaled(const ForceProblem& problem)
{
    ScaledProblem result;
    result.length = lengthOf(problem);
    result.force = forceOf(problem, result.length);
    const ContactLaw law = simplified(problem.law);
    result.law = law;
    result.law.torsion /= result.length;
    const Eigen::Index d = coordinateCount(law);
    result.coordinates = d;
    result.graspMap.resize(6, d * contactCount(problem));
    for (Eigen::Index i = 0; i < contactCount(problem); ++i)
    {
        result.graspMap.middleCols(d * i, d) = contactBasis(
            problem.contacts[static_cast<std::size_t>(i)], law, problem.reference, result.length);
    }
    result.target = -problem.load / result.force;
    result.target.tail<3>() /= result.length;
    result.maxNormalForce = problem.maxNormalForce / result.force;

    // A torsional moment is `length` times its coordinate.
    Eigen::MatrixXd torques = torqueMap(problem, law);
    if (law.model == ContactModel::SoftFinger)
    {
        for (Eigen::Index i = 0; i < contactCount(problem); ++i)
        {
            result.graspMap.col(d * i + 3) *= result.length;
            torques.col(d * i + 3) *= result.length;
        }
    }
    std::vector<Eigen::Index>& limited = result.limitedJoints;
    const Eigen::Map<const Eigen::VectorXd> allLimits = vectorOf(problem.torqueLimits);
    for (Eigen::Index j = 0; j < allLimits.size(); ++j)
    {
        // A joint that no contact loads stays within any limit.
        if (std::isfinite(allLimits[j]) && torques.row(j).norm() > 0.0)
        {
            limited.push_back(j);
        }
    }
    const Eigen::VectorXd limits = allLimits(limited) / result.force;
    result.torqueMap = torques(limited, Eigen::all);
    const Eigen::VectorXd sizes = result.torqueMap.rowwise().norm().cwiseMax(limits);
    result.torqueMap.array().colwise() /= sizes.array();
    result.torqueLimits = limits.cwiseQuotient(sizes);
    result.torqueScales = result.force * sizes;
    return result;
}

Eigen::VectorXd jointTorques(const ForceProblem& problem,
                             const ContactLaw& law,
                             const Eigen::MatrixXd& local)
{
    return torqueMap(problem, law) * local.reshaped();
}
}  // namespace bullet_ccd::grasp
