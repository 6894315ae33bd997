/// A proof that no contact forces balance a load, and what it says in words.
///
/// Move the object by a virtual twist u and the joints at rates v. Were there forces f in their
/// cones with G f = -load, torques within +-limit and normal parts below the largest, then
///     u . (-load) = sum_i f_i . (G_i^T u - J_i v - l_i n_i) + v . tau + sum_i l_i f_n,i
///                <= sum_i f_n,i h_i + sum_j |v_j| limit_j + sum_i l_i f_max,
/// h_i the support of cone i in the direction in brackets and l_i >= 0. Where all h_i are 0 or
/// less, a load with u . (-load) above the last two sums cannot be balanced.
#pragma once

#include "grasp/force/force_problem.h"

#include <optional>

namespace bullet_ccd::grasp
{
struct ForceCertificate
{
    Wrench direction = Wrench::Zero();  ///< u: linear part; angular part times `length`
    double length = 1.0;                ///< [m]
    Eigen::VectorXd jointRates;         ///< v, one a column of the Jacobian
    Eigen::VectorXd normalRates;        ///< l, one a contact
    /// Rounding leaves h_i a little above 0: what is proven is that no forces whose normal parts
    /// sum to less than this balance the load [N].
    double provenUpTo = 0.0;

    /// Friction alone is the reason: neither joint limits nor the largest normal force take part.
    [[nodiscard]] bool coneOnly() const;
};

/// Multipliers of a solver, in units of the scaled problem; signs as in the formula above.
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
