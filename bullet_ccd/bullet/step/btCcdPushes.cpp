#include "bullet_ccd/bullet/step/btCcdPushes.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

void btCcdPushes::noteEnd()
{
    m_ends.clear();
    if (m_world.getSolverInfo().m_splitImpulse == 0 ||
        m_world.getDispatcher()->getNumManifolds() == 0)
    {
        return;
    }
    const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
    m_ends.reserve(std::size_t(bodies.size()));
    for (int i = 0; i < bodies.size(); ++i)
    {
        m_ends.emplace(bodies[i], bodies[i]->getWorldTransform());
    }
}

void btCcdPushes::forget(const btCollisionObject& object)
{
    m_ends.erase(btRigidBody::upcast(&object));
}

const std::vector<btCcdPushes::Push>& btCcdPushes::find(btScalar timeStep, bool integrated)
{
    m_pushes.clear();
    m_looked.clear();
    const btContactSolverInfo& info = m_world.getSolverInfo();
    if (m_ends.empty() || info.m_splitImpulse == 0)
    {
        return m_pushes;
    }
    btDispatcher& dispatcher = *m_world.getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        btScalar deepest = 0;
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            deepest = std::min(deepest, manifold.getContactPoint(k).getDistance());
        }
        if (deepest > info.m_splitImpulsePenetrationThreshold || deepest >= btScalar(0))
        {
            continue;
        }
        for (const btCollisionObject* object : {manifold.getBody0(), manifold.getBody1()})
        {
            auto* body = btRigidBody::upcast(const_cast<btCollisionObject*>(object));
            if (body != nullptr && !body->isStaticOrKinematicObject())
            {
                look(body, -deepest, timeStep, integrated);
            }
        }
    }
    return m_pushes;
}

void btCcdPushes::look(btRigidBody* body, btScalar depth, btScalar timeStep, bool integrated)
{
    const auto end = m_ends.find(body);
    if (end == m_ends.end() || end->second == body->getWorldTransform() ||
        m_looked.count(body) != 0)
    {
        return;
    }
    btVector3 pushed = body->getWorldTransform().getOrigin() - end->second.getOrigin();
    if (integrated)
    {
        pushed -= body->getLinearVelocity() * timeStep;
    }
    if (pushed.length() > btScalar(2) * depth)
    {
        return;
    }
    Push push{body, end->second, {0, 0, 0}, {0, 0, 0}};
    btTransformUtil::calculateVelocity(
        end->second, body->getWorldTransform(), timeStep, push.m_linear, push.m_angular);
    m_pushes.push_back(push);
    m_looked.insert(body);
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
    auto* multiBodyWorld = dynamic_cast<btMultiBodyDynamicsWorld*>(&world);
    for (int i = 0; multiBodyWorld != nullptr && i < multiBodyWorld->getNumMultibodies() && alone;
         ++i)
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
