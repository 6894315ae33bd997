#include "bullet_ccd/bullet/step/btCcdImpactSolver.h"

#include "bullet_ccd/bullet/kernels/btCcdRows.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdProgress.h"

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

namespace
{
constexpr int kIterations = 4;           // times those of the world
constexpr int kThoroughIterations = 10;  // for contacts that come again
/// The solver is done where no row changes a velocity by more [m/s].
constexpr btScalar kSolved = btScalar(1e-6);
/// So many objects of a heap take part, and what is joined to them: fewer where something hits it,
/// which goes on to others by impacts of its own, than where it lies and presses.
constexpr std::size_t kMostHit = 4;
constexpr std::size_t kMostPressed = 32;
/// Under an action, which answers for a body only so often.
constexpr std::size_t kMostHitOfAction = 8;
/// Slower ones press [m/s].
constexpr btScalar kHit = btScalar(3);
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

/// True if Bullet moves it: such objects are in islands.
bool isMoved(const btCollisionObject& object)
{
    return object.getIslandTag() >= 0;
}

/// Links count as if they were at rest.
bool isHit(const btCcdImpact& impact)
{
    const auto velocityOf = [](const btCollisionObject* object, const btVector3& point)
    {
        const btRigidBody* body = btRigidBody::upcast(object);
        return body != nullptr
                   ? body->getVelocityInLocalPoint(point - body->getCenterOfMassPosition())
                   : btVector3(0, 0, 0);
    };
    const btVector3 approach = velocityOf(impact.m_objectA, impact.m_pointA) -
                               velocityOf(impact.m_objectB, impact.m_pointB);
    return approach.dot(impact.m_normal) > kHit;
}

/// The partners of an object in the broadphase.
class Overlapping : public btBroadphaseAabbCallback
{
public:
    explicit Overlapping(const btBroadphaseProxy& proxy) : m_proxy(proxy) {}
    bool process(const btBroadphaseProxy* found) override
    {
        // btAxisSweep3 finds proxies of another broadphase, which is its own.
        auto* proxy = static_cast<btCollisionObject*>(found->m_clientObject)->getBroadphaseHandle();
        if (proxy != &m_proxy)
        {
            m_found.push_back(proxy);
        }
        return true;
    }
    void add(const btBroadphaseProxy& proxy)
    {
        if (std::find(m_found.begin(), m_found.end(), &proxy) == m_found.end())
        {
            m_found.push_back(const_cast<btBroadphaseProxy*>(&proxy));
        }
    }

    std::vector<btBroadphaseProxy*> m_found;

private:
    const btBroadphaseProxy& m_proxy;
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

/// Contacts with a stiffness or an error reduction of their own are hard for an instant: what they
/// push with over time has had its share of the step already.
class WithoutSkins
{
public:
    explicit WithoutSkins(const std::vector<btPersistentManifold*>& manifolds)
    {
        for (btPersistentManifold* manifold : manifolds)
        {
            for (int k = 0; k < manifold->getNumContacts(); ++k)
            {
                btManifoldPoint& point = manifold->getContactPoint(k);
                if ((point.m_contactPointFlags & kOverTime) != 0)
                {
                    m_saved.emplace_back(&point, point.m_contactPointFlags);
                    point.m_contactPointFlags &= ~kOverTime;
                }
            }
        }
    }
    ~WithoutSkins()
    {
        for (const auto& [point, flags] : m_saved)
        {
            point->m_contactPointFlags = flags;
        }
    }
    WithoutSkins(const WithoutSkins&) = delete;
    WithoutSkins& operator=(const WithoutSkins&) = delete;

private:
    static constexpr int kOverTime =
        BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING | BT_CONTACT_FLAG_HAS_CONTACT_ERP;
    std::vector<std::pair<btManifoldPoint*, int>> m_saved;
};

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
            manifold.setNumContacts(1);
            manifold.getContactPoint(0) = {};
            manifold.getContactPoint(0).m_localPointA.setValue(kFarOff, kFarOff, kFarOff);
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
    info.m_leastSquaresResidualThreshold =
        std::max(info.m_leastSquaresResidualThreshold, kSolved * kSolved);
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

btCcdImpactSolver::btCcdImpactSolver(btDiscreteDynamicsWorld& world, btCcdProgress& progress)
    : m_world(world),
      m_progress(progress),
      m_multiBodyWorld(dynamic_cast<btMultiBodyDynamicsWorld*>(&world))
{
}

void btCcdImpactSolver::beginStep()
{
    m_isListed = false;
}

inline btCollisionObject& btCcdImpactSolver::at(int index) const
{
    return *m_world.getCollisionObjectArray()[index];
}

bool btCcdImpactSolver::isIn(const btCollisionObject& object) const
{
    const auto index = std::size_t(object.getWorldArrayIndex());
    return index < m_isReached.size() && m_isReached[index] != 0;
}

/// What acts on what, once in a step. Contacts may be gone by the time that they are asked for.
void btCcdImpactSolver::list()
{
    if (m_isListed)
    {
        return;
    }
    m_isListed = true;
    const auto count = std::size_t(m_world.getNumCollisionObjects());
    m_touching.resize(count);
    for (std::vector<int>& touching : m_touching)
    {
        touching.clear();
    }
    m_isReached.assign(count, 0);
    m_reached.clear();
    btDispatcher& dispatcher = *m_world.getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        if (manifold.getNumContacts() > 0)
        {
            noteContact(*manifold.getBody0(), *manifold.getBody1());
        }
    }
    m_joints.clear();
    for (int i = 0; i < m_world.getNumConstraints(); ++i)
    {
        btTypedConstraint* joint = m_world.getConstraint(i);
        for (const btRigidBody* body : {&joint->getRigidBodyA(), &joint->getRigidBodyB()})
        {
            if (joint->isEnabled() && isMoved(*body))
            {
                m_joints[body->getWorldArrayIndex()].push_back(joint);
            }
        }
    }
}

void btCcdImpactSolver::noteContact(const btCollisionObject& a, const btCollisionObject& b)
{
    for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &a)})
    {
        const auto index = std::size_t(from->getWorldArrayIndex());
        if (!isMoved(*from) || index >= m_touching.size())
        {
            continue;
        }
        std::vector<int>& touching = m_touching[index];
        const int other = to->getWorldArrayIndex();
        if (std::find(touching.begin(), touching.end(), other) == touching.end())
        {
            touching.push_back(other);
        }
    }
}

/// Discrete contacts of everything that the objects of the impacts are near to.
void btCcdImpactSolver::findContacts(const std::vector<btCcdImpact>& impacts)
{
    btBroadphaseInterface& broadphase = *m_world.getBroadphase();
    btOverlappingPairCache& pairs = *m_world.getPairCache();
    auto& dispatcher = static_cast<btCollisionDispatcher&>(*m_world.getDispatcher());
    std::vector<btCollisionObject*> touching;
    for (const btCcdImpact& impact : impacts)
    {
        for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
        {
            if (std::find(touching.begin(), touching.end(), object) == touching.end())
            {
                touching.push_back(object);
                m_progress.bring(*object);
                m_world.updateSingleAabb(object);
            }
        }
    }
    for (std::size_t i = 0; i < touching.size(); ++i)
    {
        btBroadphaseProxy* proxy = touching[i]->getBroadphaseHandle();
        // What is fixed touches too much; what moves finds it.
        if (!isMoved(*touching[i]))
        {
            continue;
        }
        Overlapping partners(*proxy);
        broadphase.aabbTest(proxy->m_aabbMin, proxy->m_aabbMax, partners);
        // What it has touched before and does not overlap any more parts now.
        for (const int former : m_touching[std::size_t(touching[i]->getWorldArrayIndex())])
        {
            btBroadphaseProxy* other = at(former).getBroadphaseHandle();
            if (pairs.findPair(proxy, other) != nullptr)
            {
                partners.add(*other);
            }
        }
        for (btBroadphaseProxy* other : partners.m_found)
        {
            const auto* object = static_cast<const btCollisionObject*>(other->m_clientObject);
            const auto end = touching.begin() + std::ptrdiff_t(i);
            if (isMoved(*object) && std::find(touching.begin(), end, object) != end)
            {
                continue;  // done the other way round
            }
            btBroadphasePair* pair = pairs.findPair(proxy, other);
            if (pair == nullptr)
            {
                pair = pairs.addOverlappingPair(proxy, other);
            }
            if (pair == nullptr)
            {
                continue;
            }
            m_progress.bring(*object);
            dispatcher.getNearCallback()(*pair, dispatcher, m_world.getDispatchInfo());
            if (pair->m_algorithm != nullptr)
            {
                noteContact(*touching[i], *object);
            }
        }
    }
}

/// What takes part in the impacts: objects, multibodies and manifolds.
void btCcdImpactSolver::collect(const std::vector<btCcdImpact>& impacts, bool rigid)
{
    list();
    for (const int index : m_reached)
    {
        m_isReached[std::size_t(index)] = 0;
    }
    m_reached.clear();
    m_contacts.clear();
    const std::size_t mostHit = rigid ? kMostHitOfAction : kMostHit;
    m_most = std::any_of(impacts.begin(), impacts.end(), isHit) ? mostHit : kMostPressed;
    for (const btCcdImpact& impact : impacts)
    {
        reach(*impact.m_objectA);
        reach(*impact.m_objectB);
    }
    const std::size_t met = m_reached.size();
    for (std::size_t i = 0; i < m_reached.size(); ++i)
    {
        const btCollisionObject& object = at(m_reached[i]);
        reachJoined(object);
        reachTouching(object, i < met);
    }
    std::sort(m_reached.begin(), m_reached.end());
    m_objects.clear();
    m_multiBodies.clear();
    for (const int index : m_reached)
    {
        btCollisionObject& object = at(index);
        m_progress.bring(object);
        if (!object.isActive())
        {
            object.activate();  // of what is awake it would put off the sleep
        }
        m_objects.push_back(&object);
        btMultiBody* body = multiBodyOf(&object);
        if (body != nullptr &&
            std::find(m_multiBodies.begin(), m_multiBodies.end(), body) == m_multiBodies.end())
        {
            m_multiBodies.push_back(body);
        }
    }
    m_manifolds.clear();
    for (const Contact& contact : m_contacts)
    {
        if (isIn(at(contact.m_to)) || !isMoved(at(contact.m_to)))
        {
            m_manifolds.push_back(contact.m_manifold);
        }
    }
}

void btCcdImpactSolver::reach(const btCollisionObject& object)
{
    if (isMoved(object) && !isIn(object) &&
        std::size_t(object.getWorldArrayIndex()) < m_isReached.size())
    {
        m_isReached[std::size_t(object.getWorldArrayIndex())] = 1;
        m_reached.push_back(object.getWorldArrayIndex());
    }
}

/// Joints are never cut.
void btCcdImpactSolver::reachJoined(const btCollisionObject& object)
{
    if (const auto joints = m_joints.find(object.getWorldArrayIndex()); joints != m_joints.end())
    {
        for (const btTypedConstraint* joint : joints->second)
        {
            reach(joint->getRigidBodyA());
            reach(joint->getRigidBodyB());
        }
    }
    const btMultiBody* body = multiBodyOf(&object);
    if (body == nullptr)
    {
        return;
    }
    forColliders(*body, [this](const btMultiBodyLinkCollider& collider) { reach(collider); });
    const int joints =
        m_multiBodyWorld != nullptr ? m_multiBodyWorld->getNumMultiBodyConstraints() : 0;
    for (int i = 0; i < joints; ++i)
    {
        btMultiBodyConstraint& joint = *m_multiBodyWorld->getMultiBodyConstraint(i);
        if (joint.getMultiBodyA() != body && joint.getMultiBodyB() != body)
        {
            continue;
        }
        for (const btMultiBody* end : {joint.getMultiBodyA(), joint.getMultiBodyB()})
        {
            if (end != nullptr)
            {
                forColliders(*end,
                             [this](const btMultiBodyLinkCollider& collider) { reach(collider); });
            }
        }
    }
}

/// Every contact is found from the end that is reached first.
/// @param met its contacts are those of the present time
void btCcdImpactSolver::reachTouching(const btCollisionObject& object, bool met)
{
    auto& dispatcher = static_cast<btCollisionDispatcher&>(*m_world.getDispatcher());
    btManifoldArray manifolds;
    const int index = object.getWorldArrayIndex();
    for (const int other : m_touching[std::size_t(index)])
    {
        btCollisionObject& partner = at(other);
        const auto isSame = [&](const Contact& contact)
        { return contact.m_from == other && contact.m_to == index; };
        if (isIn(partner) && std::any_of(m_contacts.begin(), m_contacts.end(), isSame))
        {
            continue;
        }
        btBroadphasePair* pair = m_world.getPairCache()->findPair(
            const_cast<btBroadphaseProxy*>(object.getBroadphaseHandle()),
            partner.getBroadphaseHandle());
        if (pair == nullptr || pair->m_algorithm == nullptr ||
            !dispatcher.needsResponse(&object, &partner))
        {
            continue;
        }
        if (partner.isKinematicObject() && !met)
        {
            // Bullet has found the contacts of the two where the kinematic one is to be.
            m_progress.bring(object);
            m_progress.bring(partner);
            dispatcher.getNearCallback()(*pair, dispatcher, m_world.getDispatchInfo());
        }
        manifolds.resize(0);
        pair->m_algorithm->getAllContactManifolds(manifolds);
        bool touches = false;
        for (int i = 0; i < manifolds.size(); ++i)
        {
            if (manifolds[i]->getNumContacts() > 0)
            {
                touches = true;
                m_contacts.push_back({index, other, manifolds[i]});
            }
        }
        if (touches && m_reached.size() < m_most)
        {
            reach(partner);
        }
    }
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
    const WithoutSkins withoutSkins(m_manifolds);
    std::vector<std::unique_ptr<RigidRows>> joints;
    std::vector<btTypedConstraint*> constraints;
    static const std::vector<btTypedConstraint*> kNoJoints;
    for (const int index : m_reached)
    {
        const auto known = m_joints.find(index);
        for (btTypedConstraint* joint : known != m_joints.end() ? known->second : kNoJoints)
        {
            const btRigidBody& bodyA = joint->getRigidBodyA();
            const btRigidBody& first = isMoved(bodyA) ? bodyA : joint->getRigidBodyB();
            if (joint->isEnabled() && first.getWorldArrayIndex() == index)
            {
                joints.push_back(std::make_unique<RigidRows>(*joint));
                constraints.push_back(joints.back().get());
            }
        }
    }
    const WithoutForces withoutForces(m_objects);
    const btContactSolverInfo info = impactInfo(m_world.getSolverInfo(), answer);
    btConstraintSolver& solver = *m_world.getConstraintSolver();
    const btCcdQuickRows quickRows(solver, info.m_solverMode);
    solver.prepareSolve(int(m_objects.size()), int(m_manifolds.size()));
    // Another solver of such a world is asked for rigid bodies only, as Bullet does.
    auto* multiBodySolver =
        m_multiBodyWorld != nullptr ? dynamic_cast<btMultiBodyConstraintSolver*>(&solver) : nullptr;
    if (multiBodySolver == nullptr)
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
    multiBodySolver->solveMultiBodyGroup(m_objects.data(),
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
    const std::vector<btCcdImpact>& impacts, btCcdAnswer answer, bool rigid)
{
    BT_PROFILE("btCcdImpactSolver::solve");
    std::vector<SavedImpulses> saved;
    list();
    findContacts(impacts);
    collect(impacts, rigid);
    if (rigid && !m_multiBodies.empty())
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
