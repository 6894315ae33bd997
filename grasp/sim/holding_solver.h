/// A constraint solver for Bullet's multibody worlds whose static friction is static.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/sim/contact_program.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>

#include <vector>

namespace bullet_ccd::grasp
{
/// Drop-in for btMultiBodyConstraintSolver. Bullet's sweeps never start multibody friction from
/// where the step before left it, and stop before they have converged, so what a hand holds creeps.
/// This solver takes Bullet's rows, starts all of them from the impulses of the step before, and
/// solves all rows of an island together (solveContacts()): normals, friction in round cones,
/// motors, joint limits, and contacts between rigid bodies as well.
///
/// configure() sets what it needs of a world: two friction directions that do not depend on
/// velocities. Islands with joints between rigid bodies, with rolling or spinning friction, or with
/// more than kMostRows rows are left to Bullet's sweeps, and so counted.
class BULLET_CCD_API HoldingSolver : public btMultiBodyConstraintSolver
{
public:
    static constexpr int kMostRows = 900;

    struct Counters
    {
        long solves = 0;      ///< of islands
        long iterations = 0;  ///< over all of these
        long failures = 0;    ///< solves in which the method did not come to an end
        long left = 0;        ///< islands left to Bullet's sweeps
    };

    /// Sets the solver modes, a full warm start, and the iterations allowed.
    static void configure(btContactSolverInfo& info);

    /// The velocity by which a row may be off [m/s or rad/s].
    void setAccuracy(double accuracy) { m_accuracy = accuracy; }
    [[nodiscard]] const Counters& counters() const { return m_counters; }

private:
    struct Island;

    double m_accuracy = 1e-6;
    Counters m_counters;

    void apply(btMultiBodySolverConstraint& row, double impulse);
    void apply(btSolverConstraint& row, double impulse);
    [[nodiscard]] bool isOurs() const;
    void startFromStepBefore(const btContactSolverInfo& info);
    void solveIsland(const btContactSolverInfo& info);

    btScalar solveGroupCacheFriendlySetup(btCollisionObject** bodies,
                                          int numBodies,
                                          btPersistentManifold** manifolds,
                                          int numManifolds,
                                          btTypedConstraint** constraints,
                                          int numConstraints,
                                          const btContactSolverInfo& info,
                                          btIDebugDraw* drawer) override;
    btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies,
                                               int numBodies,
                                               btPersistentManifold** manifolds,
                                               int numManifolds,
                                               btTypedConstraint** constraints,
                                               int numConstraints,
                                               const btContactSolverInfo& info,
                                               btIDebugDraw* drawer) override;
};
}  // namespace bullet_ccd::grasp
