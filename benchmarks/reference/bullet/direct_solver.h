/// Bullet's direct solvers for the forces of contacts and motors.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyMLCPConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolverInterface.h>

#include <memory>

namespace bullet_ccd::reference
{
/// A world's solver with what solves its mixed linear complementarity problem: btDantzigSolver or
/// btLemkeSolver. Friction has pyramids; where the problem is not solved, Bullet sweeps.
template <typename Problem>
class DirectSolver : private Problem, public btMultiBodyMLCPConstraintSolver
{
public:
    DirectSolver() : btMultiBodyMLCPConstraintSolver(static_cast<Problem*>(this)) {}
};
}  // namespace bullet_ccd::reference
