#include "bullet_ccd/bullet/step/btCcdBody.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

namespace
{
/// Of the joints that are not moved by the user.
template <typename Change>
void forJointRates(btMultiBody& body, const Change& change)
{
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        for (int dof = 0; dof < body.getLink(i).m_dofCount && !body.isLinkKinematic(i); ++dof)
        {
            change(body.getJointVelMultiDof(i)[dof]);
        }
    }
}

btVector3 zero()
{
    return {0, 0, 0};
}
}  // namespace

btCcdBody btCcdBody::of(btCollisionObject* object)
{
    if (const auto* collider = btMultiBodyLinkCollider::upcast(object))
    {
        return {nullptr, collider->m_multiBody};
    }
    return {btRigidBody::upcast(object), nullptr};
}

const btCollisionObject* btCcdBody::collider() const
{
    if (m_multiBody == nullptr)
    {
        return m_rigidBody;
    }
    const btCollisionObject* collider = m_multiBody->getBaseCollider();
    for (int i = 0; i < m_multiBody->getNumLinks() && collider == nullptr; ++i)
    {
        collider = m_multiBody->getLink(i).m_collider;
    }
    return collider;
}

bool btCcdBody::isFree() const
{
    return m_multiBody != nullptr ||
           (m_rigidBody != nullptr && !m_rigidBody->isStaticOrKinematicObject());
}

bool btCcdBody::isStill() const
{
    if (m_multiBody == nullptr)
    {
        return m_rigidBody == nullptr || (m_rigidBody->getLinearVelocity() == zero() &&
                                          m_rigidBody->getAngularVelocity() == zero());
    }
    const btScalar* joints = m_multiBody->getVelocityVector() + 6;
    return m_multiBody->getBaseVel() == zero() && m_multiBody->getBaseOmega() == zero() &&
           std::all_of(joints,
                       joints + m_multiBody->getNumDofs(),
                       [](btScalar rate) { return rate == btScalar(0); });
}

btVector3 btCcdBody::velocity() const
{
    return m_rigidBody != nullptr   ? m_rigidBody->getLinearVelocity()
           : m_multiBody != nullptr ? m_multiBody->getBaseVel()
                                    : zero();
}

btScalar btCcdBody::mobility() const
{
    if (m_multiBody == nullptr)
    {
        return isFree() ? m_rigidBody->getInvMass() : btScalar(0);
    }
    if (m_multiBody->hasFixedBase() || m_multiBody->isBaseKinematic())
    {
        return 0;
    }
    btScalar mass = m_multiBody->getBaseMass();
    for (int i = 0; i < m_multiBody->getNumLinks(); ++i)
    {
        mass += m_multiBody->getLinkMass(i);
    }
    return btScalar(1) / mass;
}

btVector3 btCcdBody::spin(int link) const
{
    if (m_rigidBody != nullptr)
    {
        return m_rigidBody->getAngularVelocity();
    }
    if (link == kBase)
    {
        return m_multiBody->getBaseOmega();
    }
    const btScalar* velocity = m_multiBody->getJointVelMultiDof(link);
    return {velocity[0], velocity[1], velocity[2]};
}

void btCcdBody::setSpin(int link, const btVector3& spin) const
{
    if (m_rigidBody != nullptr)
    {
        m_rigidBody->setAngularVelocity(spin);
    }
    else if (link == kBase)
    {
        m_multiBody->setBaseOmega(spin);
    }
    else
    {
        std::copy_n(&spin[0], 3, m_multiBody->getJointVelMultiDof(link));
    }
}

void btCcdBody::calm(btScalar factor) const
{
    if (m_rigidBody != nullptr)
    {
        m_rigidBody->setAngularVelocity(m_rigidBody->getAngularVelocity() * factor);
        return;
    }
    if (!m_multiBody->isBaseKinematic())
    {
        m_multiBody->setBaseOmega(m_multiBody->getBaseOmega() * factor);
    }
    forJointRates(*m_multiBody, [factor](btScalar& rate) { rate *= factor; });
}

void btCcdBody::slide(const btVector3& impulse) const
{
    if (m_rigidBody != nullptr)
    {
        if (!m_rigidBody->isStaticOrKinematicObject())
        {
            m_rigidBody->applyCentralImpulse(impulse);
            m_rigidBody->setAngularVelocity(zero());
        }
    }
    else if (m_multiBody != nullptr)
    {
        m_multiBody->setBaseVel(m_multiBody->getBaseVel() + mobility() * impulse);
        calm(btScalar(0));
    }
}

void btCcdBody::setVelocity(const btVector3& linear, const btVector3& angular) const
{
    btCcdStop(*this);
    if (m_rigidBody != nullptr)
    {
        m_rigidBody->setLinearVelocity(linear);
        m_rigidBody->setAngularVelocity(angular);
    }
    else if (mobility() > btScalar(0))
    {
        m_multiBody->setBaseVel(linear);
        m_multiBody->setBaseOmega(angular);
    }
}

btCcdVelocities::btCcdVelocities(const btCcdBody& body)
    : m_body(body), m_linear(body.velocity()), m_angular(body.spin(btCcdBody::kBase))
{
    if (const btMultiBody* multiBody = body.m_multiBody)
    {
        const btScalar* joints = multiBody->getVelocityVector() + 6;
        m_joints.assign(joints, joints + multiBody->getNumDofs());
    }
}

void btCcdVelocities::restore() const
{
    if (btRigidBody* rigidBody = m_body.m_rigidBody)
    {
        rigidBody->setLinearVelocity(m_linear);
        rigidBody->setAngularVelocity(m_angular);
        return;
    }
    btMultiBody& body = *m_body.m_multiBody;
    if (!body.isBaseKinematic())
    {
        body.setBaseVel(m_linear);
        body.setBaseOmega(m_angular);
    }
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        const btMultibodyLink& link = body.getLink(i);
        // A link that was stopped for good in the meantime stays stopped.
        for (int dof = 0; dof < link.m_dofCount && !body.isLinkKinematic(i); ++dof)
        {
            body.getJointVelMultiDof(i)[dof] = m_joints[std::size_t(link.m_dofOffset + dof)];
        }
    }
}

void btCcdStop(const btCcdBody& body)
{
    if (btRigidBody* rigidBody = body.m_rigidBody)
    {
        rigidBody->setLinearVelocity(zero());
        rigidBody->setAngularVelocity(zero());
        return;
    }
    btMultiBody& multiBody = *body.m_multiBody;
    multiBody.setBaseVel(zero());
    multiBody.setBaseOmega(zero());
    for (int i = 0; i < multiBody.getNumLinks(); ++i)
    {
        std::fill_n(multiBody.getJointVelMultiDof(i), multiBody.getLink(i).m_dofCount, btScalar(0));
    }
}
