#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdStopLink.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

namespace
{
bool isStill(const btMultiBody& body)
{
    bool still =
        body.getBaseVel() == btVector3(0, 0, 0) && body.getBaseOmega() == btVector3(0, 0, 0);
    for (int i = 0; i < body.getNumDofs(); ++i)
    {
        still = still && body.getVelocityVector()[6 + i] == btScalar(0);
    }
    return still;
}

/// `spin` shortened so that no part of the step can run into the integrator's limit, which counts
/// per call: a step in two parts would otherwise turn further than the whole.
btVector3 limitedSpin(const btVector3& spin, btScalar timeStep)
{
    const btScalar limit = ANGULAR_MOTION_THRESHOLD;
    const btScalar angle = spin.length() * timeStep;
    return angle > limit ? btVector3(spin * (limit * btScalar(0.999999) / angle)) : spin;
}
}  // namespace

btCcdMultiBodyDynamicsWorld::btCcdMultiBodyDynamicsWorld(
    btDispatcher* dispatcher,
    btBroadphaseInterface* pairCache,
    btMultiBodyConstraintSolver* constraintSolver,
    btCollisionConfiguration* collisionConfiguration)
    : btMultiBodyDynamicsWorld(dispatcher, pairCache, constraintSolver, collisionConfiguration)
{
}

void btCcdMultiBodyDynamicsWorld::setCcdTolerance(double tolerance)
{
    btAssert(tolerance > 0.0);
    m_tolerance = tolerance;
}

void btCcdMultiBodyDynamicsWorld::stopLinkOnFirstContact(btMultiBody* body, int link)
{
    m_stopLinks.insert({body, link});
}

void btCcdMultiBodyDynamicsWorld::integrateTransforms(btScalar timeStep)
{
    beginStep(timeStep);
    btScalar elapsed = 0;
    for (int event = 0; elapsed < timeStep; ++event)
    {
        const btScalar remaining = timeStep - elapsed;
        if (event == m_maxEvents)
        {
            ++m_counters.m_eventLimits;
            holdEverything(remaining);
            break;
        }
        const btCcdAnswer answer =
            m_stepper.firstImpact({m_collisionObjects,
                                   *m_dispatcher1,
                                   *m_broadphasePairCache->getOverlappingPairCache(),
                                   remaining,
                                   m_tolerance});
        ++m_counters.m_queries;
        m_counters.m_overlaps += answer.m_overlaps;
        m_counters.m_unsupported = answer.m_unsupported;

        const bool free = answer.m_status == bullet_ccd::ToiStatus::Separated;
        const btScalar advance =
            free ? remaining : btCcdRoundDown(answer.m_fraction * double(remaining));
        if (advance > btScalar(0))
        {
            btMultiBodyDynamicsWorld::integrateTransforms(advance);
        }
        if (free)
        {
            break;
        }
        elapsed += advance;
        if (answer.m_status == bullet_ccd::ToiStatus::IterationLimit)
        {
            ++m_counters.m_iterationLimits;
            holdEverything(timeStep - elapsed);
            break;
        }
        for (btCcdImpact impact : answer.m_impacts)
        {
            impact.m_time = elapsed;
            respond(impact, timeStep - elapsed);
        }
    }
    endStep();
}

void btCcdMultiBodyDynamicsWorld::beginStep(btScalar timeStep)
{
    for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
    {
        btRigidBody* body = m_nonStaticRigidBodies[i];
        // Stock clamping would stop the body short of where the query took it to be.
        m_stockThresholds.emplace_back(body, body->getCcdMotionThreshold());
        body->setCcdMotionThreshold(btScalar(0));
        const btVector3 spin = body->getAngularVelocity();
        const btVector3 limited = limitedSpin(spin, timeStep);
        if (limited != spin)
        {
            m_limitedSpins.push_back({nullptr, body, spin, limited});
            body->setAngularVelocity(limited);
        }
    }
    for (int i = 0; i < m_multiBodies.size(); ++i)
    {
        btMultiBody* body = m_multiBodies[i];
        const btVector3 spin = body->getBaseOmega();
        const btVector3 limited = limitedSpin(spin, timeStep);
        if (limited != spin)
        {
            m_limitedSpins.push_back({body, nullptr, spin, limited});
            body->setBaseOmega(limited);
        }
    }
}

void btCcdMultiBodyDynamicsWorld::endStep()
{
    for (const Held& held : m_held)
    {
        if (held.m_rigidBody != nullptr)
        {
            held.m_rigidBody->setLinearVelocity(held.m_linear);
            held.m_rigidBody->setAngularVelocity(held.m_angular);
            continue;
        }
        btMultiBody& body = *held.m_multiBody;
        if (!body.isBaseKinematic())
        {
            body.setBaseVel(held.m_linear);
            body.setBaseOmega(held.m_angular);
        }
        for (int i = 0; i < body.getNumLinks(); ++i)
        {
            const btMultibodyLink& link = body.getLink(i);
            // A link that was stopped for good while its body was held stays stopped.
            for (int dof = 0; dof < link.m_dofCount && !body.isLinkKinematic(i); ++dof)
            {
                body.getJointVelMultiDof(i)[dof] =
                    held.m_joints[std::size_t(link.m_dofOffset + dof)];
            }
        }
    }
    m_held.clear();
    for (const Limited& spin : m_limitedSpins)
    {
        if (spin.m_rigidBody != nullptr && spin.m_rigidBody->getAngularVelocity() == spin.m_limited)
        {
            spin.m_rigidBody->setAngularVelocity(spin.m_wanted);
        }
        if (spin.m_multiBody != nullptr && spin.m_multiBody->getBaseOmega() == spin.m_limited)
        {
            spin.m_multiBody->setBaseOmega(spin.m_wanted);
        }
    }
    m_limitedSpins.clear();
    for (const auto& [body, threshold] : m_stockThresholds)
    {
        body->setCcdMotionThreshold(threshold);
    }
    m_stockThresholds.clear();
}

void btCcdMultiBodyDynamicsWorld::respond(const btCcdImpact& impact, btScalar remaining)
{
    ++m_counters.m_impacts;
    const bool handled =
        m_listener != nullptr && m_listener->onImpact(impact) == btCcdAfterImpact::Continue;
    const bool stoppedA = stopWatchedLink(impact.m_objectA, impact.m_linkA);
    const bool stoppedB = stopWatchedLink(impact.m_objectB, impact.m_linkB);
    if (handled)
    {
        return;
    }
    if (!stoppedA)
    {
        hold(impact.m_objectA, remaining);
    }
    if (!stoppedB)
    {
        hold(impact.m_objectB, remaining);
    }
}

bool btCcdMultiBodyDynamicsWorld::stopWatchedLink(const btCollisionObject* object, int link)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(object);
    if (collider == nullptr)
    {
        return false;
    }
    const auto watched = m_stopLinks.find({collider->m_multiBody, link});
    if (watched == m_stopLinks.end())
    {
        return false;
    }
    m_stopLinks.erase(watched);
    return btCcdStopLink(*collider->m_multiBody, link);
}

void btCcdMultiBodyDynamicsWorld::hold(btCollisionObject* object, btScalar remaining)
{
    if (btMultiBodyLinkCollider* collider = btMultiBodyLinkCollider::upcast(object))
    {
        holdMultiBody(*collider->m_multiBody, remaining);
    }
    else if (btRigidBody* body = btRigidBody::upcast(object))
    {
        holdRigidBody(*body, remaining);
    }
}

void btCcdMultiBodyDynamicsWorld::holdMultiBody(btMultiBody& body, btScalar remaining)
{
    if (isStill(body))
    {
        return;  // stands, or is held already
    }
    const btScalar* joints = body.getVelocityVector() + 6;
    m_held.push_back({&body,
                      nullptr,
                      body.getBaseVel(),
                      body.getBaseOmega(),
                      std::vector<btScalar>(joints, joints + body.getNumDofs())});
    body.setBaseVel(btVector3(0, 0, 0));
    body.setBaseOmega(btVector3(0, 0, 0));
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        std::fill_n(body.getJointVelMultiDof(i), body.getLink(i).m_dofCount, btScalar(0));
    }
    countHold(remaining);
}

void btCcdMultiBodyDynamicsWorld::holdRigidBody(btRigidBody& body, btScalar remaining)
{
    const btVector3 zero(0, 0, 0);
    if (body.isStaticOrKinematicObject() ||
        (body.getLinearVelocity() == zero && body.getAngularVelocity() == zero))
    {
        return;
    }
    m_held.push_back({nullptr, &body, body.getLinearVelocity(), body.getAngularVelocity(), {}});
    body.setLinearVelocity(zero);
    body.setAngularVelocity(zero);
    countHold(remaining);
}

void btCcdMultiBodyDynamicsWorld::holdEverything(btScalar remaining)
{
    for (int i = 0; i < m_multiBodies.size(); ++i)
    {
        holdMultiBody(*m_multiBodies[i], remaining);
    }
    for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
    {
        holdRigidBody(*m_nonStaticRigidBodies[i], remaining);
    }
}

void btCcdMultiBodyDynamicsWorld::countHold(btScalar remaining)
{
    ++m_counters.m_clamps;
    m_counters.m_lostTime += double(remaining);
}
