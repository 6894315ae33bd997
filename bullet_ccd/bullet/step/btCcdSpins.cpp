#include "bullet_ccd/bullet/step/btCcdSpins.h"

#include "bullet_ccd/bullet/step/btCcdStepper.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>

namespace
{
constexpr int kMostPieces = 100;
/// Of the limit of Bullet's integrator, for a whole step and for a piece of it.
constexpr btScalar kWhole = btScalar(0.999999);
constexpr btScalar kPiece = btScalar(0.99);

btVector3 limitedSpin(const btVector3& spin, btScalar timeStep)
{
    const btScalar limit = ANGULAR_MOTION_THRESHOLD;
    const btScalar angle = spin.length() * timeStep;
    return angle > limit ? btVector3(spin * (limit * kWhole / angle)) : spin;
}
}  // namespace

btCcdSpins::btCcdSpins(btDiscreteDynamicsWorld& world)
    : m_world(world), m_multiBodyWorld(dynamic_cast<btMultiBodyDynamicsWorld*>(&world))
{
}

bool btCcdSpins::limit(btScalar timeStep)
{
    const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
    for (int i = 0; i < bodies.size(); ++i)
    {
        limit({bodies[i], nullptr}, timeStep);
    }
    for (int i = 0; m_multiBodyWorld != nullptr && i < m_multiBodyWorld->getNumMultibodies(); ++i)
    {
        limit({nullptr, m_multiBodyWorld->getMultiBody(i)}, timeStep);
    }
    return !m_limited.empty();
}

void btCcdSpins::limit(const btCcdBody& body, btScalar timeStep)
{
    const btCollisionObject* collider = body.collider();
    if (collider == nullptr)
    {
        return;  // meets nothing
    }
    body.forSpins(
        [&](int link)
        {
            const btVector3 spin = body.spin(link);
            const btVector3 limited = limitedSpin(spin, timeStep);
            if (limited != spin)
            {
                m_limited.push_back({body, link, collider, spin, limited});
                body.setSpin(link, limited);
            }
        });
}

void btCcdSpins::restore()
{
    for (const Limited& spin : m_limited)
    {
        if (spin.m_body.spin(spin.m_link) == spin.m_limited)
        {
            spin.m_body.setSpin(spin.m_link, spin.m_wanted);
        }
    }
    m_limited.clear();
}

void btCcdSpins::free(btCcdStepper& stepper)
{
    for (const Limited& spin : m_limited)
    {
        m_free.insert(spin.m_body);
        stepper.changed(*spin.m_collider);
    }
    restore();
}

int btCcdSpins::pieces(const btCcdBody& body, btScalar time)
{
    btScalar fastest = 0;
    body.forSpins([&](int link) { fastest = std::max(fastest, body.spin(link).length()); });
    return std::clamp(
        int(std::ceil(fastest * time / (ANGULAR_MOTION_THRESHOLD * kPiece))), 1, kMostPieces);
}

int btCcdSpins::pieces(btRigidBody& body, btScalar time) const
{
    const btCcdBody freed{&body, nullptr};
    return m_free.count(freed) != 0 ? pieces(freed, time) : 1;
}

int btCcdSpins::pieces(btScalar time) const
{
    int most = 1;
    for (const btCcdBody& body : m_free)
    {
        most = std::max(most, body.m_multiBody != nullptr ? pieces(body, time) : 1);
    }
    return most;
}

void btCcdSpins::endStep()
{
    m_free.clear();
    restore();
}
