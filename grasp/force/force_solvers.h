/// The two solvers behind solveGraspForces(), on scaled problems.
#pragma once

#include "grasp/force/force_certificate.h"
#include "grasp/force/grasp_forces.h"

namespace bullet_ccd::grasp
{
/// In units of the scaled problem.
struct ScaledForces
{
    ForceStatus status = ForceStatus::Undecided;
    Eigen::VectorXd forces;  ///< of Balanced
    double value = 0.0;
    double bound = 0.0;
    ForceMultipliers multipliers;  ///< of Infeasible, not yet verified
    int iterations = 0;
};

/// @pre the problem has contacts
[[nodiscard]] ScaledForces solveByCones(const ScaledProblem& problem, ForceObjective objective);
/// @pre the problem has contacts
[[nodiscard]] ScaledForces solveByPyramids(const ScaledProblem& problem,
                                           ForceObjective objective,
                                           int edges);
}  // namespace bullet_ccd::grasp
