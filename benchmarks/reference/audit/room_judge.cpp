#include "benchmarks/reference/audit/room_judge.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd::reference
{
namespace
{
double reachAlong(const btCollisionShape& shape,
                  const btTransform& pose,
                  const btVector3& direction)
{
    if (shape.isCompound())
    {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        double reach = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < compound.getNumChildShapes(); ++i)
        {
            const btTransform child = pose * compound.getChildTransform(i);
            reach = std::max(reach, reachAlong(*compound.getChildShape(i), child, direction));
        }
        return reach;
    }
    const btVector3 local = direction * pose.getBasis();
    const double origin(direction.dot(pose.getOrigin()));
    if (shape.isConvex())
    {
        const auto& convex = static_cast<const btConvexShape&>(shape);
        return origin + double(local.dot(convex.localGetSupportingVertex(local)));
    }
    double reach = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p :
         dynamic_cast<const btCcdMeshShape&>(shape).tree().mesh().vertices)
    {
        reach = std::max(reach, p.dot(btCcdToEigen(local)));
    }
    return origin + reach;
}

/// A point inside the body.
btVector3 middleOf(const btRigidBody& body)
{
    btVector3 middle(0, 0, 0);
    if (body.getCollisionShape()->getShapeType() == CONVEX_HULL_SHAPE_PROXYTYPE)
    {
        const auto* hull = static_cast<const btConvexHullShape*>(body.getCollisionShape());
        for (int i = 0; i < hull->getNumPoints(); ++i)
        {
            middle += hull->getScaledPoint(i) / btScalar(hull->getNumPoints());
        }
    }
    return body.getWorldTransform() * middle;
}

btVector3 normalOf(int axis, double side)
{
    btVector3 normal(0, 0, 0);
    normal[axis] = btScalar(side);
    return normal;
}
}  // namespace

double reachOf(const btRigidBody& body, const btVector3& direction)
{
    return reachAlong(*body.getCollisionShape(), body.getWorldTransform(), direction);
}

void RoomJudge::beginsInWall(const btRigidBody& body, int axis, int side)
{
    Seen& seen = m_seen[&body];
    seen = {.place = body.getWorldTransform().getOrigin(),
            .axis = axis,
            .side = side == 0 ? -1.0 : 1.0};
    ++m_begunInWalls;
}

bool RoomJudge::isComingOut(const btRigidBody& body) const
{
    const auto found = m_seen.find(&body);
    return found != m_seen.end() && found->second.side != 0.0;
}

bool RoomJudge::isInMiddleOfWall(const btVector3& at) const
{
    for (std::size_t k = 0; k < 3; ++k)
    {
        const double x(at[int(k)]);
        if (std::abs(x) > m_room.half + m_room.walls[k][x > 0 ? 1 : 0] + 1e-3)
        {
            return true;
        }
    }
    return false;
}

RoomFinding RoomJudge::look(const btRigidBody& body)
{
    const btVector3 at = middleOf(body);
    const btVector3& velocity = body.getLinearVelocity();
    if (!std::isfinite(at.length2()) || !std::isfinite(velocity.length2()) ||
        !std::isfinite(body.getAngularVelocity().length2()))
    {
        return RoomFinding::NotFinite;
    }
    const auto [entry, isNew] = m_seen.try_emplace(&body);
    Seen& seen = entry->second;
    const bool isOut = isInMiddleOfWall(at);
    const bool beganInWall = seen.side != 0.0;
    if (beganInWall)
    {
        seen.time += m_timeStep;
        const double depth = reachOf(body, normalOf(seen.axis, seen.side)) - m_room.half;
        const bool isLate = isOut || (depth > kOut && seen.time > kTimeToComeOut);
        m_notComeOut += isLate ? 1 : 0;
        seen.side = depth <= kOut || isLate ? 0.0 : seen.side;
    }
    if (isOut)
    {
        return beganInWall ? RoomFinding::OutFromAWall : RoomFinding::Out;
    }
    const btVector3& place = body.getWorldTransform().getOrigin();
    const double speed(velocity.length());
    const bool isHeld = !isNew && speed > 0.1 &&
                        velocity.dot(seen.velocity) > seen.velocity.length2() &&
                        double((place - seen.place).length()) < kStill * speed * m_timeStep;
    seen.held = isHeld ? seen.held + 1 : 0;
    seen.freeSpeed = isHeld ? seen.freeSpeed : speed;
    seen.place = place;
    seen.velocity = velocity;
    return seen.held >= kHeldSteps && speed > seen.freeSpeed + kGathered ? RoomFinding::GathersSpeed
                                                                         : RoomFinding::Nothing;
}
}  // namespace bullet_ccd::reference
