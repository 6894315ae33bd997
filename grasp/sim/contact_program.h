/// Impulses of contacts with round friction cones and of drives with limits, all at once.
///
/// The rows are drives, limits and couplings first, which are bounded one by one, then contacts of
/// three rows each: the normal and two tangents. An impulse x changes the velocities of the bodies
/// by u = M^-1 J^T x and those of the rows by J u. What is sought is an x within its bounds and
/// cones such that, with the velocities v = J u + compliance x - b that are left,
///     a bounded row    has v = 0, or is at the bound that keeps it from it;
///     a contact        either does not approach, or presses; it sticks within the cone, or slides
///                      at its edge against the direction of sliding (Coulomb's law).
///
/// The method is Newton's, on the velocities of the bodies, of which there are few however many
/// contacts there are. Each row gets a grain of compliance about the impulse that it had, which
/// makes impulses a function of velocities: a projection on bounds and cones. The velocities at
/// which both agree are the minimum of a convex function. From one minimum to the next the impulses
/// follow, until the grain does nothing (the proximal point method); so friction is static.
/// Sources: Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton
/// like solution methods", 1991; Rockafellar, "Monotone operators and the proximal point
/// algorithm", 1976.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Core>

#include <vector>

namespace bullet_ccd::grasp
{
struct ContactProgram
{
    Eigen::MatrixXd J;           ///< n x q: velocities of the rows of unit velocities of the bodies
    Eigen::MatrixXd W;           ///< n x q: velocities of the bodies of unit impulses (J M^-1)
    Eigen::VectorXd compliance;  ///< n: velocity by which a unit impulse gives way [1/kg]
    Eigen::VectorXd b;           ///< n: the velocity that each row lacks without impulses
    Eigen::VectorXd lower;       ///< of the bounded rows
    Eigen::VectorXd upper;       ///< of the bounded rows
    std::vector<double> friction;  ///< mu of each contact
};

struct ContactProgramOptions
{
    double accuracy = 1e-6;   ///< largest disagreement of a row [m/s or rad/s]
    int maxIterations = 200;  ///< Newton steps of each part
};

struct ContactProgramEffort
{
    int iterations = 0;  ///< Newton steps of all parts
    int unfinished = 0;  ///< parts for which the steps did not suffice
};

/// Improves x, which is where it starts. What does not move each other is a part, solved for
/// itself. The answer is always within its bounds and cones, also where the steps do not suffice.
BULLET_CCD_API ContactProgramEffort solveContacts(const ContactProgram& program,
                                                  Eigen::VectorXd& x,
                                                  const ContactProgramOptions& options);
}  // namespace bullet_ccd::grasp
