#include "bullet_ccd/bullet/step/btCcdPushes.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

void btCcdPushes::notePoses()
{
    const auto count = std::size_t(m_world.getNumCollisionObjects());
    if (m_ends.size() != count)
    {
        m_ends.assign(count, {});
    }
    const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
    for (int i = 0; i < bodies.size(); ++i)
    {
        const auto index = std::size_t(bodies[i]->getWorldArrayIndex());
        if (index < m_ends.size())
        {
            End& end = m_ends[index];
            end.m_body = bodies[i];
            end.m_pose = bodies[i]->getWorldTransform();
            end.m_isLooked = false;
        }
    }
}

void btCcdPushes::forget(const btCollisionObject& object)
{
    if (End* end = endOf(object))
    {
        *end = {};
    }
}

/// Null if it is not known.
btCcdPushes::End* btCcdPushes::endOf(const btCollisionObject& object)
{
    const auto index = std::size_t(object.getWorldArrayIndex());
    if (index < m_ends.size() && m_ends[index].m_body == &object)
    {
        return &m_ends[index];
    }
    // Objects change places where others have been removed.
    const auto found = std::find_if(
        m_ends.begin(), m_ends.end(), [&](const End& end) { return end.m_body == &object; });
    return found != m_ends.end() ? &*found : nullptr;
}

/// True if no point of the body is farther from where it was there than half of what Bullet's boxes
/// are larger than shapes.
bool btCcdPushes::isNear(const btRigidBody& body, const btTransform& pose)
{
    const btTransform& now = body.getWorldTransform();
    btScalar turned = 0;
    for (int k = 0; k < 3; ++k)
    {
        turned += now.getBasis().getColumn(k).distance2(pose.getBasis().getColumn(k));
    }
    const btScalar reach = body.getCollisionShape()->getAngularMotionDisc();
    return now.getOrigin().distance(pose.getOrigin()) + btSqrt(turned) * reach <=
           btScalar(0.5) * gContactBreakingThreshold;
}

/// If any may be.
void btCcdPushes::findDeepOnes()
{
    const btScalar threshold = m_world.getSolverInfo().m_splitImpulsePenetrationThreshold;
    btDispatcher& dispatcher = *m_world.getDispatcher();
    btPersistentManifold* const* manifolds = dispatcher.getInternalManifoldPointer();
    for (int i = 0, count = dispatcher.getNumManifolds(); i < count; ++i)
    {
        const btPersistentManifold& manifold = *manifolds[i];
        btScalar deepest = 0;
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            deepest = std::min(deepest, manifold.getContactPoint(k).getDistance());
        }
        if (deepest > threshold || deepest >= btScalar(0))
        {
            continue;
        }
        for (const btCollisionObject* object : {manifold.getBody0(), manifold.getBody1()})
        {
            auto* body = btRigidBody::upcast(const_cast<btCollisionObject*>(object));
            if (body != nullptr && !body->isStaticOrKinematicObject())
            {
                m_deep.push_back({body, -deepest});
            }
        }
    }
}

void btCcdPushes::noteBeforeSolving()
{
    m_isNotedBefore = true;
    findDeep();
    if (m_deep.empty())
    {
        return;
    }
    m_ends.resize(std::size_t(m_world.getNumCollisionObjects()));
    for (const Deep& deep : m_deep)
    {
        m_ends[std::size_t(deep.m_body->getWorldArrayIndex())] = {
            deep.m_body, deep.m_body->getWorldTransform(), false};
    }
}

void btCcdPushes::look(const Deep& deep, btScalar timeStep, bool integrated)
{
    btRigidBody* body = deep.m_body;
    End* end = endOf(*body);
    if (end == nullptr || (!integrated && !isNear(*body, end->m_pose)))
    {
        m_far.push_back(body);
    }
    if (end == nullptr || end->m_isLooked || end->m_pose == body->getWorldTransform())
    {
        return;
    }
    btVector3 pushed = body->getWorldTransform().getOrigin() - end->m_pose.getOrigin();
    if (integrated)
    {
        pushed -= body->getLinearVelocity() * timeStep;
    }
    if (pushed.length() > btScalar(2) * deep.m_depth)
    {
        return;
    }
    Push push{body,
              end->m_pose,
              {0, 0, 0},
              {0, 0, 0},
              body->getLinearVelocity(),
              body->getAngularVelocity()};
    btTransformUtil::calculateVelocity(
        end->m_pose, body->getWorldTransform(), timeStep, push.m_linear, push.m_angular);
    m_pushes.push_back(push);
    end->m_isLooked = true;
}

void btCcdPushes::giveOwnVelocity(const btCollisionObject& object) const
{
    const auto push = std::find_if(m_pushes.begin(),
                                   m_pushes.end(),
                                   [&](const Push& known) { return known.m_body == &object; });
    if (push != m_pushes.end() && push->m_body->getLinearVelocity() == push->m_linear &&
        push->m_body->getAngularVelocity() == push->m_angular)
    {
        push->m_body->setLinearVelocity(push->m_ownLinear);
        push->m_body->setAngularVelocity(push->m_ownAngular);
    }
}

btCcdPushed::btCcdPushed(btDiscreteDynamicsWorld& world,
                         const std::vector<btCcdPushes::Push>& pushes,
                         bool alone)
{
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size() && alone; ++i)
    {
        btRigidBody* body = btRigidBody::upcast(objects[i]);
        // What is kinematic is told to stand: its velocity says how it comes to where it is.
        if (body != nullptr && !body->isKinematicObject() && !btCcdBody{body, nullptr}.isStill())
        {
            m_saved.push_back({btCcdVelocities({body, nullptr}), {0, 0, 0}, {0, 0, 0}});
            btCcdStop({body, nullptr});
        }
    }
    auto* multiBodyWorld = alone ? dynamic_cast<btMultiBodyDynamicsWorld*>(&world) : nullptr;
    for (int i = 0; multiBodyWorld != nullptr && i < multiBodyWorld->getNumMultibodies(); ++i)
    {
        btMultiBody* body = multiBodyWorld->getMultiBody(i);
        const btScalar* rates = body->getVelocityVector();
        m_multiBodies.push_back({body, {rates, rates + 6 + body->getNumDofs()}});
        std::fill_n(const_cast<btScalar*>(rates), 6 + body->getNumDofs(), btScalar(0));
    }
    for (const btCcdPushes::Push& push : pushes)
    {
        const btCcdBody body{push.m_body, nullptr};
        m_saved.push_back({btCcdVelocities(body), push.m_linear, push.m_angular});
        body.setVelocity(push.m_linear, push.m_angular);
    }
}

/// In the reverse order: a body may have been stopped before it was pushed. What somebody else has
/// set in the meantime stays.
btCcdPushed::~btCcdPushed()
{
    for (auto saved = m_saved.rbegin(); saved != m_saved.rend(); ++saved)
    {
        const btRigidBody& body = *saved->m_own.body().m_rigidBody;
        if (body.getLinearVelocity() == saved->m_linear &&
            body.getAngularVelocity() == saved->m_angular)
        {
            saved->m_own.restore();
        }
    }
    for (const auto& [body, rates] : m_multiBodies)
    {
        std::copy(rates.begin(), rates.end(), const_cast<btScalar*>(body->getVelocityVector()));
    }
}
