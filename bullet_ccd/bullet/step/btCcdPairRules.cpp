#include "bullet_ccd/bullet/step/btCcdPairRules.h"

#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdPairToi.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <limits>

namespace
{
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
}

bool btCcdMayMeet(btCollisionWorld& world, const btCollisionObject& a, const btCollisionObject& b)
{
    if (!a.hasContactResponse() || !b.hasContactResponse() || !a.checkCollideWith(&b))
    {
        return false;
    }
    btDispatcher& dispatcher = *world.getDispatcher();
    return world.getPairCache()->needsBroadphaseCollision(
               const_cast<btBroadphaseProxy*>(a.getBroadphaseHandle()),
               const_cast<btBroadphaseProxy*>(b.getBroadphaseHandle())) &&
           dispatcher.needsCollision(&a, &b) && dispatcher.needsResponse(&a, &b);
}

double btCcdMayLose(btCcdContext& context, const btCcdTracked& a, const btCcdTracked& b)
{
    const btCcdShapeOutline& outlineA = a.outline();
    const btCcdShapeOutline& outlineB = b.outline();
    const bool stock = outlineA.m_ownMargin == kUnlimited && outlineB.m_ownMargin == kUnlimited;
    if (stock && !(outlineA.m_hasMesh && outlineB.m_hasMesh))
    {
        return btCcdTracker::kUnseen * (outlineA.m_depth + outlineB.m_depth);
    }
    const btCcdShapeModel* modelA = context.model(a.m_object->getCollisionShape());
    const btCcdShapeModel* modelB = context.model(b.m_object->getCollisionShape());
    return modelA != nullptr && modelB != nullptr
               ? btCcdTracker::kUnseen * btCcdReserve(*modelA, *modelB)
               : kUnlimited;
}

btTransform btCcdPoseOf(const btCcdTracked& tracked, bool done)
{
    if (tracked.m_way != nullptr)
    {
        return done ? tracked.m_way->m_end : tracked.m_way->m_start;
    }
    const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
    if (collider == nullptr)
    {
        return tracked.m_object->getWorldTransform();
    }
    const btMultiBody& body = *collider->m_multiBody;
    return collider->m_link < 0 ? body.getBaseWorldTransform()
                                : body.getLink(collider->m_link).m_cachedWorldTransform;
}

bool btCcdAreFartherApart(const btCcdContext& context,
                          const btCcdTracked& a,
                          const btCcdTracked& b,
                          double distance,
                          bool done)
{
    const double enough =
        distance + (a.m_shape->m_shell + b.m_shape->m_shell + context.m_tolerance);
    return btCcdGap(a.m_shape->m_extent,
                    btCcdPoseOf(a, done),
                    b.m_shape->m_extent,
                    btCcdPoseOf(b, done),
                    enough) > enough;
}
