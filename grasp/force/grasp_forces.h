/// Smallest contact forces that balance a load on a grasped object, within friction and joint
/// torques.
///
/// Two solvers answer the same question: an interior-point method with exact cones, and CLP with
/// pyramids inscribed in them, whose answers are possible forces as well but never better. What is
/// returned is measured afresh on the forces themselves, and "infeasible" only with a certificate
/// that was checked against the contacts (force_certificate.h). The weight of the hand itself plays
/// no part: joint torques are those that the contacts ask for.
#pragma once

#include "grasp/force/contact_models.h"
#include "grasp/force/force_certificate.h"
#include "grasp/force/force_problem.h"

#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
enum class ForceObjective : std::uint8_t
{
    Total,  ///< least sum of the normal forces
    Max,    ///< least largest normal force
    Firm,   ///< largest margin to slip: the largest t with slipMargin >= t at every contact
};

enum class ForceSolver : std::uint8_t
{
    Cone,           ///< exact cones
    LinearProgram,  ///< inscribed pyramids
};

struct ForceOptions
{
    ForceObjective objective = ForceObjective::Total;
    ForceSolver solver = ForceSolver::Cone;
    int coneEdges = 16;  ///< of the pyramids of the linear program
};

enum class ForceStatus : std::uint8_t
{
    Balanced,
    Infeasible,  ///< no forces can; the certificate proves it
    Unbounded,   ///< Firm without a limit: the more the hand squeezes, the larger the margin
    Undecided,   ///< the solver gave up, or feasibility is a matter of rounding
};
[[nodiscard]] const char* toString(ForceStatus status);

struct ContactForce
{
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< on the object, W [N]
    double normal = 0.0;                              ///< [N]
    double tangential = 0.0;                          ///< size [N]
    double torsion = 0.0;                             ///< moment about the normal [N m]
    double margin = 0.0;                              ///< slipMargin [N]
};

/// What the forces violate, measured on them.
struct ForceResiduals
{
    double force = 0.0;   ///< |sum of forces + load| [N]
    double moment = 0.0;  ///< about the reference [N m]
    double cone = 0.0;    ///< largest -margin, at least 0 [N]
    double torque = 0.0;  ///< largest excess over a joint's limit, at least 0 [N m or N]
    double normal = 0.0;  ///< largest excess over maxNormalForce, at least 0 [N]
};

struct GraspForces
{
    ForceStatus status = ForceStatus::Undecided;
    std::string reason;                  ///< of any status but Balanced, one sentence
    double value = 0.0;                  ///< of the objective [N]
    double bound = 0.0;                  ///< that no forces beat: of the cones (pyramids) used [N]
    std::vector<ContactForce> contacts;  ///< as in the problem; empty unless Balanced
    Eigen::VectorXd jointTorques;        ///< J^T f, as the columns of the Jacobian [N m or N]
    ForceResiduals residuals;
    std::optional<ForceCertificate> certificate;  ///< of Infeasible
    int iterations = 0;                           ///< of the cone solver
};

/// Guarantee: Balanced forces hold with the residuals stated, and their value is within `bound` of
/// the best up to their difference; Infeasible comes with a verified certificate. No contacts:
/// Balanced for a load of 0, else Infeasible. Throws std::invalid_argument that names the bad
/// number: see requireValid(problem). Source: Boyd and Wegbreit, "Fast computation of optimal
/// contact forces", 2007 (the programs); cone_program.h and linear_program.h (the solvers).
[[nodiscard]] GraspForces solveGraspForces(const ForceProblem& problem,
                                           const ForceOptions& options = {});
}  // namespace bullet_ccd::grasp
