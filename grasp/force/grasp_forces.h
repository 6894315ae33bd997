/// Smallest contact forces that balance a load on a grasped object, within friction and joint
/// torques. docs/glossary.md defines friction, effort and margin.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/grasp_types.h"

#include <Eigen/Geometry>

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
// How the joints of a hand move the contact points on its links, and which torques the contacts
// need: tau = J^T f.
//
// Only independent joints count. A mimic joint moves with the joint that it follows, so its
// motion, times its multiplier, is added to the motion of that joint.

/// Movable joints that follow no other joint, as ascending indices of the links below them.
/// Throws std::invalid_argument for a spherical joint, which has no single torque.
[[nodiscard]] BULLET_CCD_API std::vector<std::int32_t> independentJoints(const KinematicTree& tree);

/// One twist per independent joint and contact, joint by joint. A twist is the velocity of the
/// link's point at the contact [m/s] and the angular velocity of the link [rad/s], both in W, for a
/// speed of the joint of 1 rad/s or 1 m/s. For k contacts and q joints the result is in memory a
/// matrix of 6k rows and q columns, stored column by column.
/// @param X_WH       pose of the root link
/// @param positions  one entry per link, mimics applied [rad or m]
/// Throws std::invalid_argument for a contact of a link that does not exist.
[[nodiscard]] BULLET_CCD_API std::vector<Twist> handJacobian(
    const KinematicTree& tree,
    const Eigen::Isometry3d& X_WH,
    std::span<const double> positions,
    std::span<const GraspContact> contacts);

/// Effort limits of the independent joints [N m or N]; infinity where the robot states none. A
/// mimic joint has no motor of its own, so its limit does not count.
[[nodiscard]] BULLET_CCD_API std::vector<double> effortLimits(const KinematicTree& tree);

// Two solvers answer the same question: an interior-point method with exact cones, and CLP with
// pyramids inscribed in them. The answers of CLP are possible forces, too, but never better ones.
// All returned values are measured afresh on the forces themselves. A problem is called infeasible
// only with a certificate that was checked against the contacts (ForceCertificate). The weight of
// the hand is not considered: joint torques are those that the contacts need.

/// Contacts that hold an object, and the load on it.
struct BULLET_CCD_API ForceProblem
{
    std::vector<GraspContact> contacts;
    ContactLaw law{};
    Wrench load = Wrench::Zero();  ///< on the object: force [N], moment about `reference` [N m], W
    Eigen::Vector3d reference = Eigen::Vector3d::Zero();  ///< W [m]
    /// The k q twists that handJacobian() returns for k contacts and q joints; empty for no joint
    /// limits.
    std::vector<Twist> jacobian{};
    std::vector<double> torqueLimits{};     ///< q entries [N m or N]; infinity: no limit
    std::vector<std::string> jointNames{};  ///< q entries, for messages; empty: numbers
    double maxNormalForce = std::numeric_limits<double>::infinity();  ///< of each contact [N]

    [[nodiscard]] bool hasLimits() const;
};

/// What the forces are optimised for.
enum class ForceObjective : std::uint8_t
{
    Total,  ///< least sum of the normal forces
    Max,    ///< least largest normal force
    Firm,   ///< largest margin to slip (ContactForce::margin) that every contact can have
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
    Infeasible,  ///< no forces balance the load; the certificate proves it
    Unbounded,   ///< Firm without a limit: the more the hand squeezes, the larger the margin
    Undecided,   ///< the solver gave up, or feasibility is a matter of rounding
};
[[nodiscard]] BULLET_CCD_API const char* toString(ForceStatus status);

/// The force of one contact on the object.
struct ContactForce
{
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< on the object, W [N]
    double normal = 0.0;                              ///< [N]
    double tangential = 0.0;                          ///< size [N]
    double torsion = 0.0;                             ///< moment about the normal [N m]
    double margin = 0.0;  ///< friction left: mu f_n - sqrt(|f_t|^2 + (m_n / e)^2) [N]
};

/// By how much the forces violate each condition, measured on the forces.
struct ForceResiduals
{
    double force = 0.0;   ///< |sum of forces + load| [N]
    double moment = 0.0;  ///< about the reference [N m]
    double cone = 0.0;    ///< largest -margin, at least 0 [N]
    double torque = 0.0;  ///< largest excess over a joint's limit, at least 0 [N m or N]
    double normal = 0.0;  ///< largest excess over maxNormalForce, at least 0 [N]
};

/// A proof that no contact forces balance a load.
///
/// Move the object by a virtual twist u and the joints at rates v. Were there forces f in their
/// cones with G f = -load, torques within +-limit and normal parts below the largest, then
///     u . (-load) = sum_i f_i . (G_i^T u - J_i v - l_i n_i) + v . tau + sum_i l_i f_n,i
///                <= sum_i f_n,i h_i + sum_j |v_j| limit_j + sum_i l_i f_max,
/// where h_i is the support of cone i in the direction in brackets and l_i >= 0. Where all h_i are
/// 0 or less, a load with u . (-load) above the last two sums cannot be balanced.
struct BULLET_CCD_API ForceCertificate
{
    Wrench direction = Wrench::Zero();  ///< u: linear part; angular part times `length`
    double length = 1.0;                ///< [m]
    std::vector<double> jointRates;     ///< v, one entry per joint
    std::vector<double> normalRates;    ///< l, one entry per contact
    /// Rounding leaves h_i a little above 0: what is proven is that no forces whose normal parts
    /// sum to less than this balance the load [N].
    double provenUpTo = 0.0;

    /// Friction alone is the reason: neither joint limits nor the largest normal force take part.
    [[nodiscard]] bool coneOnly() const;
};

/// The answer to a ForceProblem.
struct GraspForces
{
    ForceStatus status = ForceStatus::Undecided;
    std::string reason;  ///< one sentence, for any status but Balanced
    double value = 0.0;  ///< of the objective [N]
    double bound = 0.0;  ///< no forces in the cones (pyramids) used have a better value [N]
    std::vector<ContactForce> contacts;  ///< as in the problem; empty unless Balanced
    std::vector<double> jointTorques;    ///< J^T f, one entry per joint [N m or N]
    ForceResiduals residuals;
    std::optional<ForceCertificate> certificate;  ///< of Infeasible
    int iterations = 0;                           ///< of the cone solver
};

/// Finds the contact forces that balance the load and are best for the objective.
///
/// Guarantee: Balanced forces hold with the stated residuals, and the best value lies between their
/// `value` and `bound`. Infeasible comes with a verified certificate. Without contacts the status
/// is Balanced for a load of 0, otherwise Infeasible.
/// Throws std::invalid_argument that names the bad number.
/// Source: Boyd and Wegbreit, "Fast computation of optimal contact forces", 2007.
[[nodiscard]] BULLET_CCD_API GraspForces solveGraspForces(const ForceProblem& problem,
                                                          const ForceOptions& options = {});
}  // namespace bullet_ccd::grasp
