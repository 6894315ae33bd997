#include "grasp/sim/holding_solver.h"

#include <algorithm>
#include <map>

namespace bullet_ccd::grasp
{
namespace
{
constexpr int kIterations = 200;

/// How a body moves when all its velocities, those of its joints included, stay as they are: its
/// acceleration field, which is not zero because what turns takes its points along arcs.
struct SteadyMotion
{
    btVector3 reference;                    // a point of the body [W]
    btVector3 acceleration{0.0, 0.0, 0.0};  // of that point
    btVector3 spin{0.0, 0.0, 0.0};
    btVector3 spinAcceleration{0.0, 0.0, 0.0};

    [[nodiscard]] btVector3 accelerationAt(const btVector3& point) const
    {
        const btVector3 r = point - reference;
        return acceleration + spinAcceleration.cross(r) + spin.cross(spin.cross(r));
    }
};

SteadyMotion steadyMotion(const btSolverBody& body)
{
    SteadyMotion motion{body.getWorldTransform().getOrigin()};
    motion.spin = body.m_angularVelocity;
    return motion;
}

/// Of the base, then of all links: from each parent to its child.
std::vector<SteadyMotion> steadyMotions(const btMultiBody& body)
{
    std::vector<SteadyMotion> motions(static_cast<std::size_t>(body.getNumLinks()) + 1);
    motions[0].reference = body.getBasePos();
    motions[0].spin = body.getBaseOmega();
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        const btMultibodyLink& link = body.getLink(i);
        const btTransform& frame = link.m_cachedWorldTransform;
        btVector3 turning(0.0, 0.0, 0.0);  // by its joint
        btVector3 passing(0.0, 0.0, 0.0);  // of its centre of mass, by its joint
        for (int k = 0; k < link.m_dofCount; ++k)
        {
            const btScalar speed = body.getJointVelMultiDof(i)[k];
            turning += speed * (frame.getBasis() * link.getAxisTop(k));
            passing += speed * (frame.getBasis() * link.getAxisBottom(k));
        }
        const SteadyMotion& parent = motions[static_cast<std::size_t>(link.m_parent + 1)];
        motions[static_cast<std::size_t>(i) + 1] = {
            frame.getOrigin(),
            parent.accelerationAt(frame.getOrigin()) + (2.0 * parent.spin + turning).cross(passing),
            parent.spin + turning,
            parent.spinAcceleration + parent.spin.cross(turning)};
    }
    return motions;
}

constexpr double kFastestTurn = 0.1;  // in a step, of what is carried along an arc [rad]

/// Rows of friction ask for velocities that are equal at the begin of a step, each at the point of
/// its own surface. What moves along an arc slips all the same: its points leave their tangents,
/// and where surfaces are apart by a skin, a common turn moves the two points differently. So
/// velocities are compared in the middle of both points, and in the middle of the step. This looks
/// ahead by the velocities that bodies have: where an impact makes them spin, it would tell nothing
/// of the step, and a hand would lose what it should catch.
class ArcCorrection
{
public:
    ArcCorrection(const btAlignedObjectArray<btSolverBody>& bodies, double timeStep)
        : m_bodies(bodies), m_timeStep(timeStep)
    {
    }

    /// What a row of friction of this contact has to ask for more.
    btScalar operator()(const btMultiBodySolverConstraint& row, const btManifoldPoint& point)
    {
        return part(ofLink(row.m_multiBodyA, row.m_linkA, row.m_solverBodyIdA),
                    row.m_contactNormal1,
                    point.getPositionWorldOnA(),
                    point.getPositionWorldOnB()) +
               part(ofLink(row.m_multiBodyB, row.m_linkB, row.m_solverBodyIdB),
                    row.m_contactNormal2,
                    point.getPositionWorldOnB(),
                    point.getPositionWorldOnA());
    }
    btScalar operator()(const btSolverConstraint& row, const btManifoldPoint& point) const
    {
        return part(steadyMotion(m_bodies[row.m_solverBodyIdA]),
                    row.m_contactNormal1,
                    point.getPositionWorldOnA(),
                    point.getPositionWorldOnB()) +
               part(steadyMotion(m_bodies[row.m_solverBodyIdB]),
                    row.m_contactNormal2,
                    point.getPositionWorldOnB(),
                    point.getPositionWorldOnA());
    }

private:
    [[nodiscard]] btScalar part(const SteadyMotion& motion,
                                const btVector3& normal,
                                const btVector3& own,
                                const btVector3& other) const
    {
        if (motion.spin.length() * m_timeStep > kFastestTurn)
        {
            return 0.0;
        }
        const btVector3 toMiddle = 0.5 * (other - own);
        return -normal.dot(motion.spin.cross(toMiddle) +
                           0.5 * m_timeStep * motion.accelerationAt(own + toMiddle));
    }

    SteadyMotion ofLink(const btMultiBody* body, int link, int solverBody)
    {
        if (body == nullptr)
        {
            return solverBody < 0 ? SteadyMotion{} : steadyMotion(m_bodies[solverBody]);
        }
        const auto [at, isNew] = m_known.try_emplace(body);
        if (isNew)
        {
            at->second = steadyMotions(*body);
        }
        return at->second[static_cast<std::size_t>(link) + 1];
    }

    const btAlignedObjectArray<btSolverBody>& m_bodies;
    double m_timeStep;
    std::map<const btMultiBody*, std::vector<SteadyMotion>> m_known;
};

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

    // An impact takes no time, and is not started warm.
    const bool takesTime = (info.m_solverMode & SOLVER_USE_WARMSTARTING) != 0;
    ArcCorrection correction(m_tmpSolverBodyPool, info.m_timeStep);
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(rows.size()); ++i)
    {
        const btMultiBodySolverConstraint& row = *rows[static_cast<std::size_t>(i)];
        island.addNumbers(i, row);
        if (takesTime && i >= bounded && (i - bounded) % 3 != 0)
        {
            const auto normal = static_cast<std::size_t>(i - (i - bounded) % 3);
            island.program.b[i] += correction(
                row, *static_cast<const btManifoldPoint*>(rows[normal]->m_originalContactPoint));
        }
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
        if (takesTime && k % 3 != 0)
        {
            island.program.b[i] += correction(
                row,
                *static_cast<const btManifoldPoint*>(rigidRows[k - k % 3]->m_originalContactPoint));
        }
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
