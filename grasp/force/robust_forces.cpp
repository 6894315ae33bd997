#include "grasp/force/robust_forces.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// 12 unit vectors along the axes and 64 along the diagonals. The support of their hull is
/// max(|u|_inf, |u|_1 / sqrt(6)), least for u = (h, h, (sqrt(6) - 2) h, 0, 0, 0), |u| = 1:
/// h = 1 / sqrt(2 + (sqrt(6) - 2)^2) = 1 / 1.48393..
std::vector<Wrench> unitDirections()
{
    std::vector<Wrench> directions;
    for (Eigen::Index axis = 0; axis < 6; ++axis)
    {
        directions.emplace_back(Wrench::Unit(axis));
        directions.emplace_back(-Wrench::Unit(axis));
    }
    for (unsigned signs = 0; signs < 64; ++signs)
    {
        Wrench& diagonal = directions.emplace_back();
        for (unsigned k = 0; k < 6; ++k)
        {
            diagonal[k] = ((signs >> k) & 1U) != 0 ? 1.0 : -1.0;
        }
        diagonal /= std::sqrt(6.0);
    }
    return directions;
}

bool isWorse(ForceObjective objective, double a, double b)
{
    return objective == ForceObjective::Firm ? a < b : a > b;
}

void addLargest(const GraspForces& forces, RobustForces& answer)
{
    answer.largestNormals.resize(forces.contacts.size(), 0.0);
    for (std::size_t i = 0; i < forces.contacts.size(); ++i)
    {
        answer.largestNormals[i] = std::max(answer.largestNormals[i], forces.contacts[i].normal);
    }
    answer.largestTorques.resize(forces.jointTorques.size(), 0.0);
    for (std::size_t j = 0; j < forces.jointTorques.size(); ++j)
    {
        answer.largestTorques[j] =
            std::max(answer.largestTorques[j], std::abs(forces.jointTorques[j]));
    }
}

/// Solves all corners; the worst one, or the first that has no answer.
RobustForces solveCorners(const ForceProblem& problem,
                          double size,
                          double torqueScale,
                          const ForceOptions& options)
{
    RobustForces answer;
    bool first = true;
    for (Wrench disturbance : unitDirections())
    {
        disturbance *= size;
        disturbance.tail<3>() *= torqueScale;
        ForceProblem corner = problem;
        corner.load += disturbance;
        const GraspForces forces = solveGraspForces(corner, options);
        if (forces.status != ForceStatus::Balanced)
        {
            answer.status = forces.status;
            answer.reason = forces.reason;
            answer.worst = forces;
            answer.worstDisturbance = disturbance;
            return answer;
        }
        addLargest(forces, answer);
        if (first || isWorse(options.objective, forces.value, answer.worst.value))
        {
            answer.worst = forces;
            answer.worstDisturbance = disturbance;
            first = false;
        }
    }
    answer.status = ForceStatus::Balanced;
    return answer;
}
}  // namespace

RobustForces solveForAnyWrench(const ForceProblem& problem,
                               const Disturbance& disturbance,
                               const ForceOptions& options)
{
    require(disturbance.size > 0.0 && std::isfinite(disturbance.size),
            "disturbance: size " + std::to_string(disturbance.size) + ": give a positive number");
    require(disturbance.torqueScale > 0.0 && std::isfinite(disturbance.torqueScale),
            "disturbance: torque scale " + std::to_string(disturbance.torqueScale) +
                ": give a positive length");
    const RobustForces within =
        solveCorners(problem, disturbance.size, disturbance.torqueScale, options);
    if (within.status != ForceStatus::Balanced)
    {
        return within;
    }
    RobustForces around = solveCorners(
        problem, kDisturbanceRatio * disturbance.size, disturbance.torqueScale, options);
    around.necessary = within.worst.value;
    if (around.status == ForceStatus::Balanced)
    {
        around.guaranteed = around.worst.value;
    }
    else
    {
        around.status = ForceStatus::Undecided;
        around.reason =
            "not shown for disturbances of this size: corners of the polytope around "
            "them, up to 1.48 times as large, have no forces (" +
            around.reason + ")";
    }
    return around;
}
}  // namespace bullet_ccd::grasp
