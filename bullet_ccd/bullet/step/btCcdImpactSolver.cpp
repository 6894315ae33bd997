#include "bullet_ccd/bullet/step/btCcdImpactSolver.h"

#include "bullet_ccd/bullet/step/btCcdContext.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodySphericalJointMotor.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <memory>
#include <numeric>

namespace
{
constexpr int kIterations = 4;           // times those of the world
constexpr int kThoroughIterations = 10;  // for contacts that come again
/// So many objects of an island take part, and what is joined to them.
constexpr std::size_t kMostObjects = 32;
/// Cosine between the normals of an impact and of its contacts.
constexpr btScalar kSameDirection = btScalar(0.5);

btMultiBody* multiBodyOf(const btCollisionObject* object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(object);
    return collider != nullptr ? collider->m_multiBody : nullptr;
}

template <typename Visit>
void forColliders(const btMultiBody& body, const Visit& visit)
{
    if (body.getBaseCollider() != nullptr)
    {
        visit(*const_cast<btMultiBodyLinkCollider*>(body.getBaseCollider()));
    }
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        if (body.getLink(i).m_collider != nullptr)
        {
            visit(*body.getLink(i).m_collider);
        }
    }
}

const btCollisionObject* anyColliderOf(const btMultiBody* body)
{
    const btCollisionObject* any = nullptr;
    if (body != nullptr)
    {
        forColliders(*body, [&](const btMultiBodyLinkCollider& collider) { any = &collider; });
    }
    return any;
}

/// Which objects act on each other, by index in the world.
class Connections
{
public:
    void add(const btCollisionObject& a, const btCollisionObject& b, bool joined)
    {
        if (a.getIslandTag() >= 0 && b.getIslandTag() >= 0)
        {
            m_all.push_back({a.getWorldArrayIndex(), b.getWorldArrayIndex(), joined});
            m_all.push_back({b.getWorldArrayIndex(), a.getWorldArrayIndex(), joined});
        }
    }
    void add(const btMultiBody& body)
    {
        const btCollisionObject* any = anyColliderOf(&body);
        forColliders(body,
                     [&](const btMultiBodyLinkCollider& collider) { add(*any, collider, true); });
    }
    /// One for those that are reached first, breadth first, until there are `most`; and for all
    /// that is joined to them.
    std::vector<char> around(std::vector<int> reached, std::size_t most, int objects)
    {
        std::vector<std::size_t> ends(std::size_t(objects) + 1, 0);
        for (const Connection& connection : m_all)
        {
            ++ends[std::size_t(connection.m_from) + 1];
        }
        std::partial_sum(ends.begin(), ends.end(), ends.begin());
        std::vector<Connection> sorted(m_all.size());
        for (const Connection& connection : m_all)
        {
            sorted[ends[std::size_t(connection.m_from)]++] = connection;
        }
        std::vector<char> isReached(std::size_t(objects), 0);
        for (const int first : reached)
        {
            isReached[std::size_t(first)] = 1;
        }
        for (std::size_t i = 0; i < reached.size(); ++i)
        {
            const auto from = std::size_t(reached[i]);
            for (std::size_t k = from > 0 ? ends[from - 1] : 0; k < ends[from]; ++k)
            {
                const auto to = std::size_t(sorted[k].m_to);
                if (isReached[to] == 0 && (sorted[k].m_isJoined || reached.size() < most))
                {
                    isReached[to] = 1;
                    reached.push_back(int(to));
                }
            }
        }
        return isReached;
    }

private:
    struct Connection
    {
        int m_from;
        int m_to;
        bool m_isJoined;
    };
    std::vector<Connection> m_all;
};

/// Takes from rigid bodies what acts on them over time, and gives it back.
class WithoutForces
{
public:
    explicit WithoutForces(const std::vector<btCollisionObject*>& objects)
    {
        for (btCollisionObject* object : objects)
        {
            if (btRigidBody* body = btRigidBody::upcast(object))
            {
                m_saved.push_back(
                    {body, body->getTotalForce(), body->getTotalTorque(), body->getFlags()});
                body->clearForces();
                body->setFlags(body->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT &
                               ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD &
                               ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
            }
        }
    }
    ~WithoutForces()
    {
        for (const Saved& saved : m_saved)
        {
            // applyCentralForce() would scale by the linear factor once more.
            saved.m_body->clearForces();
            saved.m_body->setFlags(saved.m_flags);
            const auto unscaled = [](const btVector3& force, const btVector3& factor)
            {
                return btVector3(factor.x() != btScalar(0) ? force.x() / factor.x() : btScalar(0),
                                 factor.y() != btScalar(0) ? force.y() / factor.y() : btScalar(0),
                                 factor.z() != btScalar(0) ? force.z() / factor.z() : btScalar(0));
            };
            saved.m_body->applyCentralForce(
                unscaled(saved.m_force, saved.m_body->getLinearFactor()));
            saved.m_body->applyTorque(unscaled(saved.m_torque, saved.m_body->getAngularFactor()));
        }
    }
    WithoutForces(const WithoutForces&) = delete;
    WithoutForces& operator=(const WithoutForces&) = delete;

private:
    struct Saved
    {
        btRigidBody* m_body;
        btVector3 m_force;
        btVector3 m_torque;
        int m_flags;
    };
    std::vector<Saved> m_saved;
};

/// What a joint transmits at an instant: its rows that hold, both ways or at a stop, and nothing of
/// what drives it. Motors, springs and everything else with a limited force have had their share of
/// the step already, and errors of position are none of an impact. The joint's own applied impulse
/// and feedback stay those of the step.
ATTRIBUTE_ALIGNED16(class) RigidRows : public btTypedConstraint
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    explicit RigidRows(btTypedConstraint & joint)
        : btTypedConstraint(
              joint.getConstraintType(), joint.getRigidBodyA(), joint.getRigidBodyB()),
          m_joint(joint)
    {
        setBreakingImpulseThreshold(joint.getBreakingImpulseThreshold());
        setOverrideNumSolverIterations(joint.getOverrideNumSolverIterations());
    }
    /// A joint that the impact has broken stays broken.
    ~RigidRows() override
    {
        if (!isEnabled())
        {
            m_joint.setEnabled(false);
        }
    }
    RigidRows(const RigidRows&) = delete;
    RigidRows& operator=(const RigidRows&) = delete;

    void buildJacobian() override
    {
        m_joint.buildJacobian();
    }
    void getInfo1(btConstraintInfo1 * info) override
    {
        m_joint.getInfo1(info);
        m_rows = info->m_numConstraintRows;
    }
    void getInfo2(btConstraintInfo2 * info) override
    {
        // With it, errors say how far away stops are.
        const btScalar erp = info->erp;
        info->erp = btScalar(1);
        m_joint.getInfo2(info);
        info->erp = erp;
        for (int i = 0; i < m_rows; ++i)
        {
            const int row = i * info->rowskip;
            btScalar& lower = info->m_lowerLimit[row];
            btScalar& upper = info->m_upperLimit[row];
            btScalar& error = info->m_constraintError[row];
            const bool pulls = lower <= -btScalar(BT_LARGE_FLOAT);
            const bool pushes = upper >= btScalar(BT_LARGE_FLOAT);
            // A stop that is not reached yet may be approached.
            const bool isFar = (pushes && !pulls && error < btScalar(0)) ||
                               (pulls && !pushes && error > btScalar(0));
            error = btScalar(0);
            if (isFar || (!pulls && !pushes))
            {
                lower = upper = btScalar(0);
            }
        }
    }
    void setParam(int number, btScalar value, int axis) override
    {
        m_joint.setParam(number, value, axis);
    }
    btScalar getParam(int number, int axis) const override
    {
        return m_joint.getParam(number, axis);
    }

private:
    btTypedConstraint& m_joint;
    int m_rows = 0;
};

/// Motors have had their share of the step already.
class WithoutMotors
{
public:
    void addMotor(btMultiBodyConstraint& motor)
    {
        m_motors.emplace_back(&motor, motor.getMaxAppliedImpulse());
        motor.setMaxAppliedImpulse(btScalar(0));
    }
    WithoutMotors() = default;
    ~WithoutMotors()
    {
        for (const auto& [motor, impulse] : m_motors)
        {
            motor->setMaxAppliedImpulse(impulse);
        }
    }
    WithoutMotors(const WithoutMotors&) = delete;
    WithoutMotors& operator=(const WithoutMotors&) = delete;

private:
    std::vector<std::pair<btMultiBodyConstraint*, btScalar>> m_motors;
};

bool isMotor(const btMultiBodyConstraint& constraint)
{
    return dynamic_cast<const btMultiBodyJointMotor*>(&constraint) != nullptr ||
           dynamic_cast<const btMultiBodySphericalJointMotor*>(&constraint) != nullptr;
}

/// Adds points to contacts that live for one impact: nobody is told that they start or end. A point
/// far away goes first meanwhile, which says that the contact is not new.
class PassingResult : public btManifoldResult
{
public:
    using btManifoldResult::btManifoldResult;

    void addContactPoint(const btVector3& normalOnBInWorld,
                         const btVector3& pointInWorld,
                         btScalar depth) override
    {
        btPersistentManifold& manifold = *m_manifoldPtr;
        const bool isFirst = manifold.getNumContacts() == 0;
        if (isFirst)
        {
            constexpr btScalar kFarOff = 1e15F;
            manifold.getContactPoint(0) = {};
            manifold.getContactPoint(0).m_localPointA.setValue(kFarOff, kFarOff, kFarOff);
            manifold.setNumContacts(1);
        }
        btManifoldResult::addContactPoint(normalOnBInWorld, pointInWorld, depth);
        if (isFirst)
        {
            const bool isAdded = manifold.getNumContacts() > 1;
            if (isAdded)
            {
                manifold.getContactPoint(0) = manifold.getContactPoint(1);
                manifold.getContactPoint(1).m_userPersistentData = nullptr;
            }
            manifold.setNumContacts(isAdded ? 1 : 0);
        }
    }
};

void dropQuietly(btPersistentManifold& manifold, int point)
{
    const int last = manifold.getNumContacts() - 1;
    manifold.clearUserCache(manifold.getContactPoint(point));
    std::swap(manifold.getContactPoint(point), manifold.getContactPoint(last));
    manifold.setNumContacts(last);
}

/// What users have kept with the points of a passing contact is theirs again; nobody is told that
/// it ends.
void endQuietly(btPersistentManifold& manifold)
{
    for (int k = 0; k < manifold.getNumContacts(); ++k)
    {
        manifold.clearUserCache(manifold.getContactPoint(k));
    }
    manifold.setNumContacts(0);
}

/// Impulses of contact points, for the warm start of the next step.
struct SavedImpulses
{
    btManifoldPoint* m_point;
    btScalar m_normal;
    btScalar m_lateral1;
    btScalar m_lateral2;
};

/// What the solver is told about an impact.
btContactSolverInfo impactInfo(const btContactSolverInfo& step, btCcdAnswer answer)
{
    btContactSolverInfo info = step;
    if (answer != btCcdAnswer::Part)
    {
        info.m_erp = info.m_erp2 = info.m_frictionERP = btScalar(0);
    }
    info.m_splitImpulse = 0;
    info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;
    info.m_numIterations *= answer == btCcdAnswer::Bounce ? kIterations : kThoroughIterations;
    if (answer != btCcdAnswer::Bounce)
    {
        info.m_restitutionVelocityThreshold = BT_LARGE_FLOAT;
    }
    return info;
}

btCollisionObjectWrapper wrapperOf(const btCollisionObject& object, const btTransform& pose)
{
    return {nullptr, object.getCollisionShape(), &object, pose, -1, -1};
}

/// Brings the cached inertias of the body up to where it is now; they are those of the step's
/// start.
void refreshDynamics(btMultiBody& body)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    btAlignedObjectArray<btScalar> r;
    btAlignedObjectArray<btVector3> v;
    btAlignedObjectArray<btMatrix3x3> m;
    body.computeAccelerationsArticulatedBodyAlgorithmMultiDof(
        btScalar(0), r, v, m, false, false, false);
}
}  // namespace

btCcdImpactSolver::btCcdImpactSolver(btDiscreteDynamicsWorld& world)
    : m_world(world), m_multiBodyWorld(dynamic_cast<btMultiBodyDynamicsWorld*>(&world))
{
}

void btCcdImpactSolver::beginStep()
{
    m_merged.clear();
}

int btCcdImpactSolver::island(int tag) const
{
    for (auto found = m_merged.find(tag); found != m_merged.end(); found = m_merged.find(tag))
    {
        tag = found->second;
    }
    return tag;
}

bool btCcdImpactSolver::isIn(const btCollisionObject& object) const
{
    return object.getIslandTag() >= 0 &&
           (m_isNear.empty() || m_isNear[std::size_t(object.getWorldArrayIndex())] != 0) &&
           std::find(m_islands.begin(), m_islands.end(), island(object.getIslandTag())) !=
               m_islands.end();
}

void btCcdImpactSolver::join(const btCollisionObject& a, const btCollisionObject& b)
{
    const int islandA = island(a.getIslandTag());
    const int islandB = island(b.getIslandTag());
    if (islandA >= 0 && islandB >= 0 && islandA != islandB)
    {
        m_merged[std::max(islandA, islandB)] = std::min(islandA, islandB);
    }
}

void btCcdImpactSolver::joinMultiBody(const btMultiBody& body)
{
    const btCollisionObject* first = nullptr;
    forColliders(body,
                 [&](btMultiBodyLinkCollider& collider)
                 {
                     if (collider.getIslandTag() >= 0)
                     {
                         first = first == nullptr ? &collider : first;
                         join(*first, collider);
                     }
                 });
}

/// Discrete contacts of everything that the objects of the impacts are near to.
void btCcdImpactSolver::findContacts(const std::vector<btCcdImpact>& impacts)
{
    std::vector<const btCollisionObject*> touching;
    for (const btCcdImpact& impact : impacts)
    {
        for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
        {
            touching.push_back(object);
            m_world.updateSingleAabb(object);
        }
    }
    btBroadphaseInterface& broadphase = *m_world.getBroadphase();
    auto& dispatcher = static_cast<btCollisionDispatcher&>(*m_world.getDispatcher());
    broadphase.calculateOverlappingPairs(&dispatcher);

    const auto isTouching = [&](const btBroadphaseProxy* proxy)
    {
        return std::find(touching.begin(),
                         touching.end(),
                         static_cast<const btCollisionObject*>(proxy->m_clientObject)) !=
               touching.end();
    };
    btBroadphasePairArray& pairs = m_world.getPairCache()->getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); ++i)
    {
        if (isTouching(pairs[i].m_pProxy0) || isTouching(pairs[i].m_pProxy1))
        {
            dispatcher.getNearCallback()(pairs[i], dispatcher, m_world.getDispatchInfo());
        }
    }
}

/// The island of the impacts: objects, multibodies and manifolds.
void btCcdImpactSolver::collect(const std::vector<btCcdImpact>& impacts)
{
    m_isNear.clear();
    findIslands(impacts);
    findObjects();
    findManifolds();
    if (m_objects.size() > kMostObjects)
    {
        keepNearest(impacts);
        findObjects();
    }
    for (btCollisionObject* object : m_objects)
    {
        object->activate();
    }
}

void btCcdImpactSolver::findIslands(const std::vector<btCcdImpact>& impacts)
{
    for (const btCcdImpact& impact : impacts)
    {
        join(*impact.m_objectA, *impact.m_objectB);
        for (const btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
        {
            if (const btMultiBody* body = multiBodyOf(object))
            {
                joinMultiBody(*body);
            }
        }
    }
    m_islands.clear();
    for (const btCcdImpact& impact : impacts)
    {
        for (const btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
        {
            if (object->getIslandTag() >= 0)
            {
                m_islands.push_back(island(object->getIslandTag()));
            }
        }
    }
}

void btCcdImpactSolver::findObjects()
{
    m_objects.clear();
    m_multiBodies.clear();
    btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        if (!isIn(*objects[i]))
        {
            continue;
        }
        m_objects.push_back(objects[i]);
        btMultiBody* body = multiBodyOf(objects[i]);
        if (body != nullptr &&
            std::find(m_multiBodies.begin(), m_multiBodies.end(), body) == m_multiBodies.end())
        {
            m_multiBodies.push_back(body);
        }
    }
}

void btCcdImpactSolver::findManifolds()
{
    m_manifolds.clear();
    btDispatcher& dispatcher = *m_world.getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    {
        btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
        const btCollisionObject& a = *manifold->getBody0();
        const btCollisionObject& b = *manifold->getBody1();
        if (manifold->getNumContacts() > 0 && (isIn(a) || isIn(b)) &&
            dispatcher.needsResponse(&a, &b))
        {
            m_manifolds.push_back(manifold);
        }
    }
}

/// Leaves in the island what can be reached by few contacts. Joints are never cut.
void btCcdImpactSolver::keepNearest(const std::vector<btCcdImpact>& impacts)
{
    Connections connections;
    for (const btPersistentManifold* manifold : m_manifolds)
    {
        connections.add(*manifold->getBody0(), *manifold->getBody1(), false);
    }
    for (int i = 0; i < m_world.getNumConstraints(); ++i)
    {
        const btTypedConstraint& joint = *m_world.getConstraint(i);
        connections.add(joint.getRigidBodyA(), joint.getRigidBodyB(), true);
    }
    for (const btMultiBody* body : m_multiBodies)
    {
        connections.add(*body);
    }
    const int joints =
        m_multiBodyWorld != nullptr ? m_multiBodyWorld->getNumMultiBodyConstraints() : 0;
    for (int i = 0; i < joints; ++i)
    {
        btMultiBodyConstraint& joint = *m_multiBodyWorld->getMultiBodyConstraint(i);
        const btCollisionObject* a = anyColliderOf(joint.getMultiBodyA());
        const btCollisionObject* b = anyColliderOf(joint.getMultiBodyB());
        if (a != nullptr && b != nullptr)
        {
            connections.add(*a, *b, true);
        }
    }
    std::vector<int> nearest;
    for (const btCcdImpact& impact : impacts)
    {
        for (const btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
        {
            if (object->getIslandTag() >= 0)
            {
                nearest.push_back(object->getWorldArrayIndex());
            }
        }
    }
    m_isNear = connections.around(nearest, kMostObjects, m_world.getCollisionObjectArray().size());
    const auto isBeyond = [this](const btCollisionObject& object)
    { return object.getIslandTag() >= 0 && !isIn(object); };
    std::erase_if(m_manifolds,
                  [&](const btPersistentManifold* manifold)
                  { return isBeyond(*manifold->getBody0()) || isBeyond(*manifold->getBody1()); });
}

/// True if Bullet knows a contact of the two where the time of impact found them to meet.
bool btCcdImpactSolver::isContactKnown(const btCcdImpact& impact) const
{
    const btScalar near = btScalar(btCcdContext::of(*m_world.getDispatcher()).m_tolerance);
    const auto isThere = [&](const btPersistentManifold* manifold)
    {
        const bool swapped = manifold->getBody0() != impact.m_objectA;
        if ((swapped ? manifold->getBody0() : manifold->getBody1()) != impact.m_objectB ||
            (swapped ? manifold->getBody1() : manifold->getBody0()) != impact.m_objectA)
        {
            return false;
        }
        for (int k = 0; k < manifold->getNumContacts(); ++k)
        {
            const btManifoldPoint& point = manifold->getContactPoint(k);
            const btVector3& onB =
                swapped ? point.getPositionWorldOnA() : point.getPositionWorldOnB();
            if (onB.distance2(impact.m_pointB) <= near * near)
            {
                return true;
            }
        }
        return false;
    };
    return std::any_of(m_manifolds.begin(), m_manifolds.end(), isThere);
}

/// Some of Bullet's algorithms see a contact only once shapes overlap: such an impact gets the
/// contacts that they find a little later. If none of them is where its time of impact found it,
/// it gets that one too: it may be one of cores, or GJK may have found none in single precision.
void btCcdImpactSolver::addMissingContacts(const std::vector<btCcdImpact>& impacts)
{
    btDispatcher& dispatcher = *m_world.getDispatcher();
    for (const btCcdImpact& impact : impacts)
    {
        if (impact.m_normal.isZero() || isContactKnown(impact) ||
            !dispatcher.needsResponse(impact.m_objectA, impact.m_objectB))
        {
            continue;
        }
        addContactsOfOverlap(impact);
        if (!isContactKnown(impact))
        {
            addWitness(impact);
        }
    }
}

/// The contacts of the pair with A moved along the normal until the two overlap by the tolerance;
/// their points are put back.
void btCcdImpactSolver::addContactsOfOverlap(const btCcdImpact& impact)
{
    btDispatcher& dispatcher = *m_world.getDispatcher();
    const btScalar gap = (impact.m_pointB - impact.m_pointA).dot(impact.m_normal);
    const btScalar overlap = btScalar(btCcdContext::of(dispatcher).m_tolerance);
    btTransform moved = impact.m_objectA->getWorldTransform();
    moved.setOrigin(moved.getOrigin() + (std::max(gap, btScalar(0)) + overlap) * impact.m_normal);
    const btCollisionObjectWrapper a = wrapperOf(*impact.m_objectA, moved);
    const btCollisionObjectWrapper b =
        wrapperOf(*impact.m_objectB, impact.m_objectB->getWorldTransform());
    btCollisionAlgorithm* algorithm =
        dispatcher.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    m_ownAlgorithms.push_back(algorithm);
    PassingResult result(&a, &b);
    algorithm->processCollision(&a, &b, m_world.getDispatchInfo(), &result);

    btManifoldArray found;
    algorithm->getAllContactManifolds(found);
    for (int i = 0; i < found.size(); ++i)
    {
        found[i]->refreshContactPoints(found[i]->getBody0()->getWorldTransform(),
                                       found[i]->getBody1()->getWorldTransform());
        const btScalar side = found[i]->getBody0() == impact.m_objectA ? btScalar(-1) : btScalar(1);
        for (int k = found[i]->getNumContacts(); k-- > 0;)
        {
            // A thin part may have been pushed through: its contact looks elsewhere.
            if (side * found[i]->getContactPoint(k).m_normalWorldOnB.dot(impact.m_normal) <
                kSameDirection)
            {
                dropQuietly(*found[i], k);
            }
        }
        if (found[i]->getNumContacts() > 0)
        {
            m_manifolds.push_back(found[i]);
        }
    }
}

void btCcdImpactSolver::addWitness(const btCcdImpact& impact)
{
    btPersistentManifold* manifold =
        m_world.getDispatcher()->getNewManifold(impact.m_objectA, impact.m_objectB);
    const btCollisionObjectWrapper a =
        wrapperOf(*impact.m_objectA, impact.m_objectA->getWorldTransform());
    const btCollisionObjectWrapper b =
        wrapperOf(*impact.m_objectB, impact.m_objectB->getWorldTransform());
    PassingResult result(&a, &b);
    result.setPersistentManifold(manifold);
    result.addContactPoint(-impact.m_normal, impact.m_pointB, btScalar(0));
    m_manifolds.push_back(manifold);
    m_ownManifolds.push_back(manifold);
}

void btCcdImpactSolver::releaseOwnContacts()
{
    btDispatcher& dispatcher = *m_world.getDispatcher();
    for (btPersistentManifold* manifold : m_ownManifolds)
    {
        endQuietly(*manifold);
        dispatcher.releaseManifold(manifold);
    }
    m_ownManifolds.clear();
    for (btCollisionAlgorithm* algorithm : m_ownAlgorithms)
    {
        btManifoldArray manifolds;
        algorithm->getAllContactManifolds(manifolds);
        for (int i = 0; i < manifolds.size(); ++i)
        {
            endQuietly(*manifolds[i]);
        }
        algorithm->~btCollisionAlgorithm();
        dispatcher.freeCollisionAlgorithm(algorithm);
    }
    m_ownAlgorithms.clear();
}

void btCcdImpactSolver::solveIsland(btCcdAnswer answer)
{
    WithoutMotors withoutMotors;
    std::vector<std::unique_ptr<RigidRows>> joints;
    std::vector<btTypedConstraint*> constraints;
    for (int i = 0; i < m_world.getNumConstraints(); ++i)
    {
        btTypedConstraint* constraint = m_world.getConstraint(i);
        if (constraint->isEnabled() &&
            (isIn(constraint->getRigidBodyA()) || isIn(constraint->getRigidBodyB())))
        {
            joints.push_back(std::make_unique<RigidRows>(*constraint));
            constraints.push_back(joints.back().get());
        }
    }
    const WithoutForces withoutForces(m_objects);
    const btContactSolverInfo info = impactInfo(m_world.getSolverInfo(), answer);
    btConstraintSolver& solver = *m_world.getConstraintSolver();
    solver.prepareSolve(int(m_objects.size()), int(m_manifolds.size()));
    if (m_multiBodyWorld == nullptr)
    {
        solver.solveGroup(m_objects.data(),
                          int(m_objects.size()),
                          m_manifolds.data(),
                          int(m_manifolds.size()),
                          constraints.data(),
                          int(constraints.size()),
                          info,
                          nullptr,
                          m_world.getDispatcher());
        solver.allSolved(info, nullptr);
        return;
    }
    std::vector<btMultiBodyConstraint*> multiBodyConstraints;
    for (int i = 0; i < m_multiBodyWorld->getNumMultiBodyConstraints(); ++i)
    {
        btMultiBodyConstraint* constraint = m_multiBodyWorld->getMultiBodyConstraint(i);
        const auto concerns = [this](const btMultiBody* body) {
            return std::find(m_multiBodies.begin(), m_multiBodies.end(), body) !=
                   m_multiBodies.end();
        };
        if (concerns(constraint->getMultiBodyA()) || concerns(constraint->getMultiBodyB()))
        {
            multiBodyConstraints.push_back(constraint);
            if (isMotor(*constraint))
            {
                withoutMotors.addMotor(*constraint);
            }
        }
    }
    for (btMultiBody* body : m_multiBodies)
    {
        refreshDynamics(*body);
    }
    static_cast<btMultiBodyConstraintSolver&>(solver).solveMultiBodyGroup(
        m_objects.data(),
        int(m_objects.size()),
        m_manifolds.data(),
        int(m_manifolds.size()),
        constraints.data(),
        int(constraints.size()),
        multiBodyConstraints.data(),
        int(multiBodyConstraints.size()),
        info,
        nullptr,
        m_world.getDispatcher());
    solver.allSolved(info, nullptr);
    for (btMultiBody* body : m_multiBodies)
    {
        body->processDeltaVeeMultiDof2();
    }
}

const std::vector<btCollisionObject*>& btCcdImpactSolver::solve(
    const std::vector<btCcdImpact>& impacts, btCcdAnswer answer, const Place& place)
{
    BT_PROFILE("btCcdImpactSolver::solve");
    std::vector<SavedImpulses> saved;
    findContacts(impacts);
    collect(impacts);
    if (place && !place(m_objects))
    {
        m_objects.clear();
        return m_objects;
    }
    // An impact in the middle of a step has impulses of its own.
    const auto keepsImpulses = [&](const btPersistentManifold& manifold)
    {
        return answer == btCcdAnswer::Part ||
               std::none_of(impacts.begin(),
                            impacts.end(),
                            [&](const btCcdImpact& impact)
                            {
                                return std::minmax<const btCollisionObject*>(impact.m_objectA,
                                                                             impact.m_objectB) ==
                                       std::minmax(manifold.getBody0(), manifold.getBody1());
                            });
    };
    for (btPersistentManifold* manifold : m_manifolds)
    {
        for (int k = 0; k < manifold->getNumContacts() && keepsImpulses(*manifold); ++k)
        {
            btManifoldPoint& point = manifold->getContactPoint(k);
            saved.push_back({&point,
                             point.m_appliedImpulse,
                             point.m_appliedImpulseLateral1,
                             point.m_appliedImpulseLateral2});
        }
    }
    addMissingContacts(impacts);
    solveIsland(answer);
    releaseOwnContacts();
    for (const SavedImpulses& impulses : saved)
    {
        impulses.m_point->m_appliedImpulse = impulses.m_normal;
        impulses.m_point->m_appliedImpulseLateral1 = impulses.m_lateral1;
        impulses.m_point->m_appliedImpulseLateral2 = impulses.m_lateral2;
    }
    return m_objects;
}
