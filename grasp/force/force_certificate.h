/// Checks that multipliers of a solver are a ForceCertificate, and says in words what it proves.
#pragma once

#include "grasp/force/force_problem.h"

#include <optional>

namespace bullet_ccd::grasp
{
/// Multipliers of a solver, in units of the scaled problem; signs as in the formula of
/// ForceCertificate.
struct ForceMultipliers
{
    Wrench equilibrium = Wrench::Zero();
    Eigen::VectorXd torques;  ///< one a limited joint
    Eigen::VectorXd normals;  ///< one a contact
};

/// Checks the formula for the multipliers. Nothing if they prove less than that balancing takes
/// 1e5 times the load or the limits, whichever is larger.
/// @param edges  0: exact cones; else the inscribed pyramids with that many
[[nodiscard]] std::optional<ForceCertificate> verified(const ForceProblem& problem,
                                                       const ScaledProblem& scaledProblem,
                                                       const ForceMultipliers& multipliers,
                                                       int edges);

/// "the friction cones alone cannot balance the load: .." or "joint torque limits: ..".
[[nodiscard]] std::string describe(const ForceProblem& problem,
                                   const ForceCertificate& certificate);
}  // namespace bullet_ccd::grasp
