/// What preloaded contacts hold when the fingers behind them do nothing but give way like springs.
///
/// A hand that holds its posture does not choose new forces when the load changes. The joints are
/// springs (position controllers), and so are the contacts; the object moves until the forces
/// balance the load again. The change of the contact forces is P w for a load w, with
///     P = -K G^T (G K G^T)^-1,   K = (J diag(1 / stiffness) J^T + compliance)^-1.
/// A contact keeps its place while preload and change together lie in its friction cone. Source:
/// Cutkosky and Kao, "Computing and controlling the compliance of a robotic hand", 1989; Bicchi,
/// "On the problem of decomposing grasp and manipulation forces", 1994 (internal forces that are
/// active, K).
#pragma once

#include "grasp/force/grasp_forces.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
struct ElasticHold
{
    /// The object may weigh so many times `weight`, in any direction, without a contact that slips
    /// or a joint that needs more than its limit; at most what was asked for. It is a lower bound
    /// for the elastic hand: the worst direction of every contact is taken for all of its friction.
    double weights = 0.0;
    std::vector<Eigen::Vector3d> forces;  ///< of the preload on the object, one per contact, W [N]
    std::vector<double> torques;          ///< of the preload, one entry per joint [N m or N]
};

/// The preload that holds most, or what was asked for with the least sum of normal forces.
/// @param problem     contacts, law, Jacobian and limits of the joints; `reference` is the centre
///                    of mass; load and maxNormalForce do not count
/// @param stiffness   of the joints [N m/rad or N/m]
/// @param compliance  of a contact, in all directions [m/N]
/// @param weight      [N]
/// @param asked       times that weight
/// Throws std::invalid_argument as solveGraspForces(), and for numbers that are not positive.
[[nodiscard]] ElasticHold holdElastically(const ForceProblem& problem,
                                          std::span<const double> stiffness,
                                          double compliance,
                                          double weight,
                                          double asked);
}  // namespace bullet_ccd::grasp
