#include "grasp/force/grasp_forces.h"

#include "grasp/force/force_solvers.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace bullet_ccd::grasp
{
namespace
{
constexpr const char* kUnbounded =
    "nothing limits the forces, so that the margin to slip grows with them: give effort limits or "
    "a "
    "largest normal force";
constexpr const char* kUndecided =
    "the solver stopped before it could decide: the load is at the edge of what the contacts can "
    "balance";

ScaledForces solveScaled(const ScaledProblem& problem, const ForceOptions& options)
{
    return options.solver == ForceSolver::Cone
               ? solveByCones(problem, options.objective)
               : solveByPyramids(problem, options.objective, options.coneEdges);
}

/// Local forces in N and N m, one contact a column.
Eigen::MatrixXd localForces(const ScaledProblem& problem, const Eigen::VectorXd& forces)
{
    Eigen::MatrixXd local =
        problem.force * forces.reshaped(problem.coordinates, forces.size() / problem.coordinates);
    if (problem.law.model == ContactModel::SoftFinger)
    {
        local.row(3) *= problem.length;
    }
    return local;
}

ContactForce contactForce(const GraspContact& contact, const ContactLaw& law, const LocalForce& f)
{
    const Wrench wrench = contactBasis(contact, law, contact.point, 1.0) * f;
    return {.force = wrench.head<3>(),
            .normal = f[0],
            .tangential = f.size() > 1 ? f.segment<2>(1).norm() : 0.0,
            .torsion = f.size() > 3 ? f[3] : 0.0,
            .margin = slipMargin(law, f)};
}

double largestExcess(const Eigen::VectorXd& values, const Eigen::VectorXd& limits)
{
    return values.size() > 0 ? std::max(0.0, (values - limits).maxCoeff()) : 0.0;
}

/// What the forces are worth, from the forces alone.
void measure(const ForceProblem& problem, const Eigen::MatrixXd& local, GraspForces& answer)
{
    const ContactLaw law = simplified(problem.law);
    Wrench sum = problem.load;
    for (std::size_t i = 0; i < problem.contacts.size(); ++i)
    {
        const LocalForce f = local.col(static_cast<Eigen::Index>(i));
        const ContactForce& force =
            answer.contacts.emplace_back(contactForce(problem.contacts[i], law, f));
        sum += contactBasis(problem.contacts[i], law, problem.reference, 1.0) * f;
        answer.residuals.cone = std::max(answer.residuals.cone, -force.margin);
        answer.residuals.normal =
            std::max(answer.residuals.normal, force.normal - problem.maxNormalForce);
    }
    answer.residuals.force = sum.head<3>().norm();
    answer.residuals.moment = sum.tail<3>().norm();
    const Eigen::VectorXd torques = jointTorques(problem, law, local);
    answer.jointTorques.assign(torques.begin(), torques.end());
    answer.residuals.torque = largestExcess(torques.cwiseAbs(), vectorOf(problem.torqueLimits));
}

/// The certificate that says least: without the limits if friction alone is the reason.
std::optional<ForceCertificate> certificateOf(const ForceProblem& problem,
                                              const ScaledProblem& scaledProblem,
                                              const ForceMultipliers& multipliers,
                                              const ForceOptions& options)
{
    const int edges = options.solver == ForceSolver::Cone ? 0 : options.coneEdges;
    if (problem.hasLimits())
    {
        const ForceProblem bare{.contacts = problem.contacts,
                                .law = problem.law,
                                .load = problem.load,
                                .reference = problem.reference};
        const ScaledProblem scaledBare = scaled(bare);
        ForceOptions least = options;
        least.objective = ForceObjective::Total;
        const ScaledForces forces = solveScaled(scaledBare, least);
        if (forces.status == ForceStatus::Infeasible)
        {
            if (auto certificate = verified(bare, scaledBare, forces.multipliers, edges))
            {
                return certificate;
            }
        }
    }
    return verified(problem, scaledProblem, multipliers, edges);
}

GraspForces infeasible(const ForceProblem& problem, std::optional<ForceCertificate> certificate)
{
    GraspForces answer;
    answer.status = certificate ? ForceStatus::Infeasible : ForceStatus::Undecided;
    answer.reason = certificate ? describe(problem, *certificate) : kUndecided;
    answer.certificate = std::move(certificate);
    return answer;
}

/// Without contacts the load itself is the direction in which nothing pushes back.
GraspForces withoutContacts(const ForceProblem& problem)
{
    if (problem.load.isZero(0.0))
    {
        GraspForces answer;
        answer.status = ForceStatus::Balanced;
        answer.jointTorques.assign(problem.torqueLimits.size(), 0.0);
        return answer;
    }
    const ScaledProblem scaledProblem = scaled(problem);
    const ForceMultipliers multipliers{
        .equilibrium = scaledProblem.target,
        .torques = Eigen::VectorXd::Zero(scaledProblem.torqueMap.rows()),
        .normals = {}};
    return infeasible(problem, verified(problem, scaledProblem, multipliers, 0));
}
}  // namespace

const char* toString(ForceStatus status)
{
    switch (status)
    {
        case ForceStatus::Balanced:
            return "balanced";
        case ForceStatus::Infeasible:
            return "infeasible";
        case ForceStatus::Unbounded:
            return "unbounded";
        case ForceStatus::Undecided:
            return "undecided";
    }
    return "unknown";
}

GraspForces solveGraspForces(const ForceProblem& problem, const ForceOptions& options)
{
    requireValid(problem);
    if (problem.contacts.empty())
    {
        return withoutContacts(problem);
    }
    const ScaledProblem scaledProblem = scaled(problem);
    const ScaledForces forces = solveScaled(scaledProblem, options);
    if (forces.status == ForceStatus::Infeasible)
    {
        GraspForces answer =
            infeasible(problem, certificateOf(problem, scaledProblem, forces.multipliers, options));
        answer.iterations = forces.iterations;
        return answer;
    }
    GraspForces answer;
    answer.status = forces.status;
    answer.iterations = forces.iterations;
    if (forces.status == ForceStatus::Balanced)
    {
        answer.value = scaledProblem.force * forces.value;
        answer.bound = scaledProblem.force * forces.bound;
        measure(problem, localForces(scaledProblem, forces.forces), answer);
    }
    else
    {
        answer.reason = forces.status == ForceStatus::Unbounded ? kUnbounded : kUndecided;
    }
    return answer;
}
}  // namespace bullet_ccd::grasp
