/// Contact forces for a load that is only known up to a disturbance of a given size, in any
/// direction.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/force/grasp_forces.h"

namespace bullet_ccd::grasp
{
/// All wrenches with sqrt(|force|^2 + (|moment| / torqueScale)^2) <= size, added to the load.
struct Disturbance
{
    double size = 0.0;         ///< [N]
    double torqueScale = 1.0;  ///< [m]
};

struct RobustForces
{
    /// Balanced: every disturbance can be answered with forces worth `guaranteed` or better.
    /// Infeasible: some disturbance of that size cannot be. Undecided: neither was shown.
    ForceStatus status = ForceStatus::Undecided;
    std::string reason;
    double guaranteed =
        0.0;  ///< value of the objective at the worst corner of a set around the ball
    double necessary = 0.0;  ///< at the worst corner within the ball: no answer to all is better
    GraspForces worst;       ///< forces of the corner that `guaranteed` comes from
    Wrench worstDisturbance = Wrench::Zero();  ///< force [N]; moment [N m]
    std::vector<double> largestNormals;        ///< over the corners, one a contact [N]
    std::vector<double> largestTorques;        ///< over the corners, sizes [N m or N]
};

/// The ball of disturbances lies within kDisturbanceRatio times the polytope of 76 unit directions
/// (12 along the axes, 64 along the diagonals), whose corners are solved one by one. Between
/// corners forces are mixed as the disturbances are, so that what holds at the corners holds in
/// between: cones and limits are convex. The hand is thus taken to answer each disturbance; it need
/// not squeeze beforehand for all of them.
inline constexpr double kDisturbanceRatio = 1.4840;

/// Throws as solveGraspForces(); also std::invalid_argument unless size and scale are positive.
[[nodiscard]] BULLET_CCD_API RobustForces solveForAnyWrench(const ForceProblem& problem,
                                                            const Disturbance& disturbance,
                                                            const ForceOptions& options = {});
}  // namespace bullet_ccd::grasp
