#include "bullet_ccd/bullet/step/btCcdSpins.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/step/btCcdStepper.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace
{
/// Of the limit of Bullet's integrator, for a whole step and for a piece of it.
constexpr btScalar kWhole = btScalar(0.999999);
constexpr double kPiece = 0.99;
constexpr double kWholeTurn = 2.0 * std::numbers::pi;
/// After an impact nothing turns by more [rad].
constexpr btScalar kMostAfterImpact = btScalar(12.5 * kWholeTurn);
}  // namespace

btCcdSpins::btCcdSpins(btDiscreteDynamicsWorld& world)
    : m_world(world), m_multiBodyWorld(dynamic_cast<btMultiBodyDynamicsWorld*>(&world))
{
}

template <typename Visit>
void btCcdSpins::forMultiBodies(const Visit& visit) const
{
    for (int i = 0; m_multiBodyWorld != nullptr && i < m_multiBodyWorld->getNumMultibodies(); ++i)
    {
        visit(btCcdBody{nullptr, m_multiBodyWorld->getMultiBody(i)});
    }
}

bool btCcdSpins::limit(btScalar timeStep)
{
    const btScalar threshold = ANGULAR_MOTION_THRESHOLD;
    const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
    for (int i = 0; i < bodies.size(); ++i)
    {
        limit({bodies[i], nullptr}, timeStep, threshold, threshold * kWhole);
    }
    forMultiBodies([&](const btCcdBody& body)
                   { limit(body, timeStep, threshold, threshold * kWhole); });
    return !m_limited.empty();
}

void btCcdSpins::limitAgain(btScalar remaining)
{
    for (const btCcdBody& body : m_fast)
    {
        limit(body, remaining, kMostAfterImpact, kMostAfterImpact);
    }
    m_fast.clear();  // the others keep their spins, for less time
}

void btCcdSpins::limit(const btCcdBody& body, btScalar time, btScalar most, btScalar left)
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
            const btScalar angle = spin.length() * time;
            if (angle > most)
            {
                const btVector3 limited = spin * (left / angle);
                m_limited.push_back({body, link, collider, spin, limited});
                body.setSpin(link, limited);
            }
        });
}

void btCcdSpins::restore(Spins& spins)
{
    for (const Limited& spin : spins)
    {
        if (spin.m_body.spin(spin.m_link) == spin.m_limited)
        {
            spin.m_body.setSpin(spin.m_link, spin.m_wanted);
            if (spin.m_body.m_rigidBody != nullptr)
            {
                spin.m_body.m_rigidBody->setInterpolationAngularVelocity(spin.m_wanted);
            }
        }
    }
    spins.clear();
}

void btCcdSpins::free(btCcdStepper& stepper)
{
    for (const Limited& spin : m_limited)
    {
        add(spin.m_body);
        stepper.changed(*spin.m_collider);
    }
    restore(m_limited);
}

int btCcdSpins::shorten(btRigidBody* body, double time)
{
    if (!(time > 0.0))
    {
        return 0;
    }
    if (body != nullptr)
    {
        return shorten(btCcdBody{body, nullptr}, time);
    }
    int most = 1;
    forMultiBodies([&](const btCcdBody& each) { most = std::max(most, shorten(each, time)); });
    return most;
}

int btCcdSpins::shorten(const btCcdBody& body, double time)
{
    const btCollisionObject* collider = body.collider();
    if (collider == nullptr)
    {
        return 1;
    }
    constexpr auto kLimit = double(ANGULAR_MOTION_THRESHOLD);
    int pieces = 1;
    body.forSpins(
        [&](int link)
        {
            const btVector3 spin = body.spin(link);
            double angle = btCcdToEigen(spin).norm() * time;
            if (!(angle > kLimit) || !std::isfinite(angle))
            {
                return;
            }
            const double turn = std::remainder(angle, kWholeTurn);
            if (turn != angle)
            {
                const btVector3 shortened = spin * btScalar(turn / angle);
                m_shortened.push_back({body, link, collider, spin, shortened});
                body.setSpin(link, shortened);
                angle = std::abs(turn);
            }
            pieces = std::max(pieces, int(std::ceil(angle / (kLimit * kPiece))));
        });
    return pieces;
}

void btCcdSpins::endStep()
{
    restore(m_limited);
}
