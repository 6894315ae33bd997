/// Impulses of contacts with round friction cones and of drives with limits, all at once.
///
/// The rows are drives, limits and couplings first, which are bounded one by one, then contacts of
/// three rows each: the normal and two tangents. An impulse x changes the velocities of the rows by
/// A x. What is sought is an x within its bounds and cones such that
///     a bounded row    reaches its velocity b, or is at the bound that keeps it from it;
///     a contact        either does not approach, or presses; it sticks within the cone, or slides
///                      at its edge against the direction of sliding (Coulomb's law).
///
/// The method is that of alternating directions: solve for all rows, project each block on what it
/// may do, until both agree. Of the weight between the two only the speed depends. A correction of
/// the normal velocity by mu times the sliding one makes the optimality conditions Coulomb's law.
/// Sources: Boyd et al., "Distributed optimization and statistical learning via the alternating
/// direction method of multipliers", 2011; De Saxce and Feng, "The bipotential method", 1998.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <vector>

namespace bullet_ccd::grasp
{
struct ContactProgram
{
    Eigen::MatrixXd A;      ///< n x n, symmetric: velocities of unit impulses [1/kg and the like]
    Eigen::VectorXd b;      ///< n: the velocity that each row lacks without impulses
    Eigen::VectorXd lower;  ///< of the bounded rows
    Eigen::VectorXd upper;  ///< of the bounded rows
    std::vector<double> friction;  ///< mu of each contact
};

struct ContactProgramOptions
{
    double accuracy = 1e-6;  ///< largest disagreement of a row [m/s or rad/s]
    int maxIterations = 200;
};

/// Solves one program after the other. It keeps what it has learned about their scale, so an answer
/// depends on those before it, within the accuracy.
class BULLET_CCD_API ContactProgramSolver
{
public:
    ContactProgramSolver();

    /// Improves x, which is where it starts. Returns the number of iterations. What does not move
    /// each other is solved for itself. The answer is always
    /// within its bounds and cones. Where the method of alternating directions does not come to an
    /// end, it is asked for the contacts alone: bounded rows that are within their bounds are
    /// solved for, and those at a bound stay there, until no row would change sides. Where that
    /// comes to no end either, sweeps row by row from zero give the answer, which is not exact.
    int solve(const ContactProgram& program,
              Eigen::VectorXd& x,
              const ContactProgramOptions& options);

    /// How often sweeps had to do.
    [[nodiscard]] long failures() const { return m_failures; }

private:
    int solvePart(const ContactProgram& program,
                  Eigen::VectorXd& x,
                  const ContactProgramOptions& options);
    [[nodiscard]] bool alternate(const ContactProgram& program,
                                 Eigen::VectorXd& x,
                                 const ContactProgramOptions& options,
                                 double& weight,
                                 int& iterations) const;
    [[nodiscard]] bool eliminate(const ContactProgram& program,
                                 Eigen::VectorXd& x,
                                 const ContactProgramOptions& options,
                                 int& iterations);
    void giveUp(const ContactProgram& program,
                Eigen::VectorXd& x,
                const ContactProgramOptions& options);

    double m_weight;            ///< relative to the diagonal
    double m_contactsWeight;    ///< of contacts alone
    bool m_eliminates = false;  ///< the last program needed it
    long m_failures = 0;
};
}  // namespace bullet_ccd::grasp
