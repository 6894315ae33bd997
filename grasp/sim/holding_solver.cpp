#include "grasp/sim/holding_solver.h"

#include <algorithm>

namespace bullet_ccd::grasp
{
namespace
{
constexpr int kIterations = 200;
/// A contact that did not press, and whose gap would have to close at such a speed to press in this
/// step, takes no part [m/s].
constexpr double kFarSpeed = 0.05;

/// By its gap alone: what Bullet's row lacks is also the speed at which forces would part the two,
/// were it not for what presses them together, such as a motor.
template <typename Row>
bool isFar(const Row& normal, double timeStep)
{
    const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
    return normal.m_appliedImpulse == 0.0 && point.getDistance() > kFarSpeed * timeStep;
}
}  // namespace

/// The rows of an island. Columns are the velocities of multibodies as Bullet orders them, then six
/// of each solver body.
struct HoldingSolver::Island
{
    ContactProgram program;
    Eigen::VectorXd start;

    Island(Eigen::Index bounded, Eigen::Index contacts, Eigen::Index columns)
    {
        const Eigen::Index n = bounded + 3 * contacts;
        program.J = program.W = Eigen::MatrixXd::Zero(n, columns);
        program.compliance.resize(n);
        program.b.resize(n);
        start.resize(n);
        program.lower.resize(bounded);
        program.upper.resize(bounded);
        program.friction.reserve(static_cast<std::size_t>(contacts));
    }

    template <typename Row>
    void addNumbers(Eigen::Index i, const Row& row)
    {
        const double mobility = row.m_jacDiagABInv > 0.0 ? 1.0 / row.m_jacDiagABInv : 0.0;
        program.b[i] = row.m_rhs * mobility;
        program.compliance[i] = row.m_cfm * mobility;
        start[i] = row.m_appliedImpulse;
    }

    void addBody(Eigen::Index i,
                 Eigen::Index column,
                 const btSolverBody& body,
                 const btVector3& normal,
                 const btVector3& cross,
                 const btVector3& angular)
    {
        const btVector3 linear = normal * body.internalGetInvMass();
        for (int k = 0; k < 3; ++k)
        {
            program.J(i, column + k) += normal[k];
            program.J(i, column + 3 + k) += cross[k];
            program.W(i, column + k) += linear[k];
            program.W(i, column + 3 + k) += angular[k];
        }
    }
};

void HoldingSolver::configure(btContactSolverInfo& info)
{
    info.m_solverMode |= SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS |
                         SOLVER_DISABLE_VELOCITY_DEPENDENT_FRICTION_DIRECTION;
    info.m_warmstartingFactor = 1.0;
    info.m_numIterations = kIterations;
}

void HoldingSolver::apply(btMultiBodySolverConstraint& row, double impulse)
{
    const auto side = [&](btMultiBody* body,
                          int jacobian,
                          int velocity,
                          int solverBody,
                          const btVector3& normal,
                          const btVector3& angular)
    {
        if (body != nullptr)
        {
            btScalar* change = &m_data.m_deltaVelocitiesUnitImpulse[jacobian];
            applyDeltaVee(change, impulse, velocity, body->getNumDofs() + 6);
            body->applyDeltaVeeMultiDof2(change, impulse);
        }
        else if (solverBody >= 0)
        {
            btSolverBody& rigid = m_tmpSolverBodyPool[solverBody];
            rigid.internalApplyImpulse(normal * rigid.internalGetInvMass(), angular, impulse);
        }
    };
    side(row.m_multiBodyA,
         row.m_jacAindex,
         row.m_deltaVelAindex,
         row.m_solverBodyIdA,
         row.m_contactNormal1,
         row.m_angularComponentA);
    side(row.m_multiBodyB,
         row.m_jacBindex,
         row.m_deltaVelBindex,
         row.m_solverBodyIdB,
         row.m_contactNormal2,
         row.m_angularComponentB);
    row.m_appliedImpulse += impulse;
}

void HoldingSolver::apply(btSolverConstraint& row, double impulse)
{
    btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    a.internalApplyImpulse(
        row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA, impulse);
    b.internalApplyImpulse(
        row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB, impulse);
    row.m_appliedImpulse += impulse;
}

bool HoldingSolver::isOurs() const
{
    const int contacts =
        m_multiBodyNormalContactConstraints.size() + m_tmpSolverContactConstraintPool.size();
    const int others = m_tmpSolverNonContactConstraintPool.size() +
                       m_tmpSolverContactRollingFrictionConstraintPool.size() +
                       m_multiBodyTorsionalFrictionContactConstraints.size() +
                       m_multiBodySpinningFrictionContactConstraints.size();
    // Without two directions a contact has one row of friction.
    const bool hasTwo = m_multiBodyFrictionContactConstraints.size() ==
                            2 * m_multiBodyNormalContactConstraints.size() &&
                        m_tmpSolverContactFrictionConstraintPool.size() ==
                            2 * m_tmpSolverContactConstraintPool.size();
    return others == 0 && hasTwo &&
           m_multiBodyNonContactConstraints.size() + 3 * contacts <= kMostRows;
}

/// Bullet does it for contacts of rigid bodies alone.
void HoldingSolver::startFromStepBefore(const btContactSolverInfo& info)
{
    const double factor = info.m_warmstartingFactor;
    for (int i = 0; i < m_multiBodyNormalContactConstraints.size(); ++i)
    {
        btMultiBodySolverConstraint& normal = m_multiBodyNormalContactConstraints[i];
        const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
        apply(normal, factor * point.m_appliedImpulse);
        apply(m_multiBodyFrictionContactConstraints[normal.m_frictionIndex],
              factor * point.m_appliedImpulseLateral1);
        apply(m_multiBodyFrictionContactConstraints[normal.m_frictionIndex + 1],
              factor * point.m_appliedImpulseLateral2);
    }
    for (int i = 0; i < m_multiBodyNonContactConstraints.size(); ++i)
    {
        btMultiBodySolverConstraint& row = m_multiBodyNonContactConstraints[i];
        if (row.m_orgConstraint != nullptr)
        {
            const double before =
                factor * row.m_orgConstraint->getAppliedImpulse(row.m_orgDofIndex);
            apply(row, std::clamp(before, double(row.m_lowerLimit), double(row.m_upperLimit)));
        }
    }
}

btScalar HoldingSolver::solveGroupCacheFriendlySetup(btCollisionObject** bodies,
                                                     int numBodies,
                                                     btPersistentManifold** manifolds,
                                                     int numManifolds,
                                                     btTypedConstraint** constraints,
                                                     int numConstraints,
                                                     const btContactSolverInfo& info,
                                                     btIDebugDraw* drawer)
{
    btMultiBodyConstraintSolver::solveGroupCacheFriendlySetup(
        bodies, numBodies, manifolds, numManifolds, constraints, numConstraints, info, drawer);
    // The solve of an impact asks for no warm start: impulses of a hold are nothing to start from.
    if ((info.m_solverMode & SOLVER_USE_WARMSTARTING) != 0 && isOurs())
    {
        startFromStepBefore(info);
    }
    return 0.0;
}

btScalar HoldingSolver::solveGroupCacheFriendlyIterations(btCollisionObject** bodies,
                                                          int numBodies,
                                                          btPersistentManifold** manifolds,
                                                          int numManifolds,
                                                          btTypedConstraint** constraints,
                                                          int numConstraints,
                                                          const btContactSolverInfo& info,
                                                          btIDebugDraw* drawer)
{
    if (!isOurs())
    {
        ++m_counters.left;
        return btMultiBodyConstraintSolver::solveGroupCacheFriendlyIterations(
            bodies, numBodies, manifolds, numManifolds, constraints, numConstraints, info, drawer);
    }
    solveGroupCacheFriendlySplitImpulseIterations(
        bodies, numBodies, manifolds, numManifolds, constraints, numConstraints, info, drawer);
    solveIsland(info);
    return 0.0;
}

void HoldingSolver::solveIsland(const btContactSolverInfo& info)
{
    std::vector<btMultiBodySolverConstraint*> rows;
    for (int i = 0; i < m_multiBodyNonContactConstraints.size(); ++i)
    {
        rows.push_back(&m_multiBodyNonContactConstraints[i]);
    }
    const auto bounded = static_cast<Eigen::Index>(rows.size());
    for (int i = 0; i < m_multiBodyNormalContactConstraints.size(); ++i)
    {
        btMultiBodySolverConstraint& normal = m_multiBodyNormalContactConstraints[i];
        if (isFar(normal, info.m_timeStep))
        {
            continue;
        }
        rows.push_back(&normal);
        rows.push_back(&m_multiBodyFrictionContactConstraints[normal.m_frictionIndex]);
        rows.push_back(&m_multiBodyFrictionContactConstraints[normal.m_frictionIndex + 1]);
    }
    std::vector<btSolverConstraint*> rigidRows;
    for (int i = 0; i < m_tmpSolverContactConstraintPool.size(); ++i)
    {
        btSolverConstraint& normal = m_tmpSolverContactConstraintPool[i];
        if (isFar(normal, info.m_timeStep))
        {
            continue;
        }
        rigidRows.push_back(&normal);
        rigidRows.push_back(&m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex]);
        rigidRows.push_back(&m_tmpSolverContactFrictionConstraintPool[normal.m_frictionIndex + 1]);
    }
    const auto n = static_cast<Eigen::Index>(rows.size() + rigidRows.size());
    if (n == 0)
    {
        return;
    }
    const Eigen::Index dofs = m_data.m_deltaVelocities.size();
    Island island(bounded, (n - bounded) / 3, dofs + 6 * m_tmpSolverBodyPool.size());

    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(rows.size()); ++i)
    {
        const btMultiBodySolverConstraint& row = *rows[static_cast<std::size_t>(i)];
        island.addNumbers(i, row);
        const auto side = [&](const btMultiBody* body,
                              int jacobian,
                              int velocity,
                              int solverBody,
                              const btVector3& normal,
                              const btVector3& cross,
                              const btVector3& angular)
        {
            if (body != nullptr)
            {
                for (int k = 0; k < body->getNumDofs() + 6; ++k)
                {
                    island.program.J(i, velocity + k) += m_data.m_jacobians[jacobian + k];
                    island.program.W(i, velocity + k) +=
                        m_data.m_deltaVelocitiesUnitImpulse[jacobian + k];
                }
            }
            else if (solverBody >= 0)
            {
                island.addBody(i,
                               dofs + 6 * solverBody,
                               m_tmpSolverBodyPool[solverBody],
                               normal,
                               cross,
                               angular);
            }
        };
        side(row.m_multiBodyA,
             row.m_jacAindex,
             row.m_deltaVelAindex,
             row.m_solverBodyIdA,
             row.m_contactNormal1,
             row.m_relpos1CrossNormal,
             row.m_angularComponentA);
        side(row.m_multiBodyB,
             row.m_jacBindex,
             row.m_deltaVelBindex,
             row.m_solverBodyIdB,
             row.m_contactNormal2,
             row.m_relpos2CrossNormal,
             row.m_angularComponentB);
        if (i < bounded)
        {
            island.program.lower[i] = row.m_lowerLimit;
            island.program.upper[i] = row.m_upperLimit;
        }
        else if ((i - bounded) % 3 == 1)
        {
            island.program.friction.push_back(row.m_friction);
        }
    }
    for (std::size_t k = 0; k < rigidRows.size(); ++k)
    {
        const btSolverConstraint& row = *rigidRows[k];
        const auto i = static_cast<Eigen::Index>(rows.size() + k);
        island.addNumbers(i, row);
        island.addBody(i,
                       dofs + 6 * row.m_solverBodyIdA,
                       m_tmpSolverBodyPool[row.m_solverBodyIdA],
                       row.m_contactNormal1,
                       row.m_relpos1CrossNormal,
                       row.m_angularComponentA);
        island.addBody(i,
                       dofs + 6 * row.m_solverBodyIdB,
                       m_tmpSolverBodyPool[row.m_solverBodyIdB],
                       row.m_contactNormal2,
                       row.m_relpos2CrossNormal,
                       row.m_angularComponentB);
        if (k % 3 == 1)
        {
            island.program.friction.push_back(row.m_friction);
        }
    }
    Eigen::VectorXd x = island.start;
    ++m_counters.solves;
    const ContactProgramEffort effort = solveContacts(
        island.program, x, {.accuracy = m_accuracy, .maxIterations = info.m_numIterations});
    m_counters.iterations += effort.iterations;
    m_counters.failures += effort.unfinished;
    for (std::size_t i = 0; i < rows.size(); ++i)
    {
        const auto k = static_cast<Eigen::Index>(i);
        apply(*rows[i], x[k] - island.start[k]);
    }
    for (std::size_t i = 0; i < rigidRows.size(); ++i)
    {
        const auto k = static_cast<Eigen::Index>(rows.size() + i);
        apply(*rigidRows[i], x[k] - island.start[k]);
    }
}
}  // namespace bullet_ccd::grasp
