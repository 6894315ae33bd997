#include "bullet_ccd/bullet/step/btCcdPairRules.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/shapes/btCcdGap.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdManifolds.h"
#include "bullet_ccd/bullet/step/btCcdPairToi.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace
{
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
/// Cores that keep this part of their depths, and so much more in tolerances, meet no query: see
/// askStock().
constexpr double kKeptDepth = 3.0 / 4.0;
constexpr double kKeptTolerances = 2.0;
/// Likewise of the shell of a mesh, for what is in it already and for what is not: see askShell().
constexpr double kTouchingShell = 1.0 / 3.0;
constexpr double kFreeShell = 9.0 / 8.0;
constexpr int kMostChildren = 8;
/// Bullet turns nothing farther in a step [rad].
constexpr double kMostTurn = 0.75;
constexpr std::size_t kMostVertices = 512;

double marginOf(const btCcdTracked& tracked)
{
    const btCollisionShape& shape = *tracked.m_collisionShape;
    return shape.getShapeType() == FAST_CONCAVE_MESH_PROXYTYPE ? double(shape.getMargin()) : 0.0;
}

bool isPlane(const btCcdTracked& tracked)
{
    return tracked.m_collisionShape->getShapeType() == STATIC_PLANE_PROXYTYPE;
}

bool isMesh(const btCollisionShape& shape)
{
    return shape.getShapeType() == FAST_CONCAVE_MESH_PROXYTYPE;
}

/// True if it is quickly said how far the shape reaches in a direction.
bool hasSupport(const btCollisionShape& shape)
{
    if (shape.isCompound())
    {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        bool has = compound.getNumChildShapes() <= kMostChildren;
        for (int i = 0; i < compound.getNumChildShapes() && has; ++i)
        {
            has = compound.getChildShape(i)->isConvex();
        }
        return has;
    }
    if (isMesh(shape))
    {
        return static_cast<const btCcdMeshShape&>(shape).tree().mesh().vertices.size() <=
               kMostVertices;
    }
    return shape.isConvex() || shape.getShapeType() == STATIC_PLANE_PROXYTYPE;
}

/// Such a shape, where Bullet has it.
bool isSimple(const btCcdTracked& tracked)
{
    return tracked.m_way == nullptr &&
           btMultiBodyLinkCollider::upcast(tracked.m_object) == nullptr &&
           hasSupport(*tracked.m_collisionShape) &&
           btCcdIsRotation(tracked.m_object->getWorldTransform().getBasis());
}

/// Of a plane, in the world.
btVector3 normalOf(const btCcdTracked& plane)
{
    return plane.m_object->getWorldTransform().getBasis() * plane.m_shape->m_extent.m_normal;
}

/// How far the shape reaches along the normal; of a plane, its own normal.
btScalar supportAlong(const btCollisionShape& shape,
                      const btTransform& pose,
                      const btVector3& normal)
{
    const btVector3 local = normal * pose.getBasis();
    const btScalar origin = normal.dot(pose.getOrigin());
    if (shape.isCompound())
    {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        btScalar farthest = -BT_LARGE_FLOAT;
        for (int i = 0; i < compound.getNumChildShapes(); ++i)
        {
            const btTransform child = pose * compound.getChildTransform(i);
            farthest = std::max(farthest, supportAlong(*compound.getChildShape(i), child, normal));
        }
        return farthest;
    }
    if (isMesh(shape))
    {
        const Eigen::Vector3d direction = btCcdToEigen(local);
        double farthest = -kUnlimited;
        for (const Eigen::Vector3d& vertex :
             static_cast<const btCcdMeshShape&>(shape).tree().mesh().vertices)
        {
            farthest = std::max(farthest, direction.dot(vertex));
        }
        return origin + btScalar(farthest);
    }
    if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE)
    {
        return origin + static_cast<const btStaticPlaneShape&>(shape).getPlaneConstant();
    }
    if (shape.getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
    {
        // Queries have its edges sharp; Bullet rounds them by the margin.
        const auto& cylinder = static_cast<const btCylinderShape&>(shape);
        const int axis = cylinder.getUpAxis();
        const btScalar up = btFabs(local[axis]);
        const btScalar across = btSqrt(std::max(btScalar(0), local.length2() - up * up));
        return origin + up * cylinder.getHalfExtentsWithMargin()[axis] +
               across * cylinder.getRadius();
    }
    const auto& convex = static_cast<const btConvexShape&>(shape);
    return origin + local.dot(convex.localGetSupportingVertex(local));
}

/// From A to B, from middle to middle.
btVector3 directionOfMiddles(const btCcdTracked& a, const btCcdTracked& b)
{
    const btVector3 between = b.m_object->getWorldTransform() * b.m_shape->m_extent.m_center -
                              a.m_object->getWorldTransform() * a.m_shape->m_extent.m_center;
    return between.fuzzyZero() ? btVector3(0, 0, 0) : between.normalized();
}

bool areConvex(const btCcdTracked& a, const btCcdTracked& b)
{
    return a.m_collisionShape->isConvex() && b.m_collisionShape->isConvex();
}

bool areBoxes(const btCcdTracked& a, const btCcdTracked& b)
{
    return a.m_collisionShape->getShapeType() == BOX_SHAPE_PROXYTYPE &&
           b.m_collisionShape->getShapeType() == BOX_SHAPE_PROXYTYPE;
}

/// Of the six normals of two boxes the one along which they are farthest apart; zero if they
/// overlap along all.
btVector3 directionOfBoxes(const btCcdTracked& a, const btCcdTracked& b)
{
    const std::array poses{&a.m_object->getWorldTransform(), &b.m_object->getWorldTransform()};
    const std::array halves{
        static_cast<const btBoxShape*>(a.m_collisionShape)->getHalfExtentsWithMargin(),
        static_cast<const btBoxShape*>(b.m_collisionShape)->getHalfExtentsWithMargin()};
    const btVector3 between = poses[1]->getOrigin() - poses[0]->getOrigin();
    btScalar farthest = 0;
    btVector3 direction(0, 0, 0);
    for (const std::size_t box : {0, 1})
    {
        const btMatrix3x3 turn = poses[box]->getBasis().transpose();
        const btMatrix3x3 others = (turn * poses[1 - box]->getBasis()).absolute();
        const btVector3 along = turn * between;
        const btVector3 apart = along.absolute() - halves[box] - others * halves[1 - box];
        const int axis = apart.maxAxis();
        if (apart[axis] > farthest)
        {
            farthest = apart[axis];
            direction = (along[axis] < btScalar(0) ? btScalar(-1) : btScalar(1)) * turn[axis];
        }
    }
    return direction;
}

/// One of two objects, seen along a direction towards the other.
class Side
{
public:
    Side(const btCcdTracked& tracked, const btVector3& direction)
        : m_shape(*tracked.m_collisionShape),
          m_pose(tracked.m_object->getWorldTransform()),
          m_direction(direction),
          m_reach(tracked.outline().m_reach),
          m_support(supportAlong(m_shape, m_pose, direction))
    {
        const btRigidBody* body = btRigidBody::upcast(tracked.m_object);
        if (body != nullptr && tracked.m_motion > 0.0)
        {
            m_speed = double(direction.dot(body->getLinearVelocity()));
            m_spin = tracked.m_turns ? body->getAngularVelocity() : m_spin;
            m_rate = double(m_spin.length());
        }
    }

    [[nodiscard]] double support() const { return double(m_support); }
    [[nodiscard]] double speed() const { return m_speed; }
    /// Bound of the speed along the direction that the spin gives any point [m/s].
    [[nodiscard]] double turning() const
    {
        return double(m_direction.cross(m_spin).length()) * m_reach;
    }
    /// How far it turns [rad], and how far points then are off their chords [m].
    [[nodiscard]] double turn(double time) const { return m_rate * time; }
    [[nodiscard]] double bend(double time) const { return turn(time) * turn(time) * m_reach / 8.0; }
    /// How much farther it reaches once it has turned.
    [[nodiscard]] double growth(double time) const
    {
        if (m_rate == 0.0)
        {
            return 0.0;
        }
        btTransform turned;
        btTransformUtil::integrateTransform(
            m_pose, btVector3(0, 0, 0), m_spin, btScalar(time), turned);
        return double(supportAlong(m_shape, turned, m_direction) - m_support);
    }

private:
    const btCollisionShape& m_shape;
    const btTransform& m_pose;
    btVector3 m_direction;
    double m_reach;
    btScalar m_support;
    double m_speed = 0.0;
    btVector3 m_spin = btVector3(0, 0, 0);
    double m_rate = 0.0;  // of it [rad/s]
};

/// As Bullet finds the cores of convex shapes apart.
btVector3 directionOfCores(const btCcdTracked& a, const btCcdTracked& b)
{
    btVoronoiSimplexSolver simplex;
    btGjkPairDetector detector(static_cast<const btConvexShape*>(a.m_collisionShape),
                               static_cast<const btConvexShape*>(b.m_collisionShape),
                               &simplex,
                               nullptr);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = a.m_object->getWorldTransform();
    input.m_transformB = b.m_object->getWorldTransform();
    btPointCollector found;
    detector.getClosestPoints(input, found, nullptr);
    return found.m_hasResult ? btVector3(-found.m_normalOnBInWorld) : btVector3(0, 0, 0);
}
}  // namespace

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
        return done && tracked.m_motion > 0.0 ? tracked.m_way->m_end : tracked.m_way->m_start;
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

double btCcdFreeWay(const btCcdContext& context,
                    const btCcdTracked& a,
                    const btCcdTracked& b,
                    double enough,
                    bool done)
{
    const double matters = a.m_shape->m_shell + b.m_shape->m_shell + context.m_tolerance;
    return btCcdGap(a.m_shape->m_extent,
                    btCcdPoseOf(a, done),
                    b.m_shape->m_extent,
                    btCcdPoseOf(b, done),
                    enough + matters) -
           matters;
}

bool btCcdApproach::isOf(const btCcdTracked& a, const btCcdTracked& b)
{
    return isSimple(a) && isSimple(b) && !(isPlane(a) && isPlane(b));
}

btCcdApproach::btCcdApproach(const btCcdContext& context,
                             const btCcdTracked& a,
                             const btCcdTracked& b,
                             const btBroadphasePair* pair,
                             double remaining,
                             bool done)
    : m_remaining(remaining), m_isDone(done)
{
    btManifoldArray manifolds;
    if (pair != nullptr && pair->m_algorithm != nullptr)
    {
        pair->m_algorithm->getAllContactManifolds(manifolds);
    }
    const btManifoldPoint* deepest = nullptr;
    for (int i = 0; i < manifolds.size(); ++i)
    {
        for (int k = 0; k < manifolds[i]->getNumContacts(); ++k)
        {
            const btManifoldPoint& point = manifolds[i]->getContactPoint(k);
            if (deepest == nullptr || point.getDistance() < deepest->getDistance())
            {
                deepest = &point;
            }
        }
    }
    const double tolerance = context.toleranceOf(*a.m_object, *b.m_object);
    const bool touches = deepest != nullptr && double(deepest->getDistance()) <= tolerance;
    if (isPlane(a) || isPlane(b))
    {
        look(tolerance, a, b, isPlane(a) ? normalOf(a) : btVector3(-normalOf(b)), touches);
    }
    else if (deepest == nullptr)
    {
        const btVector3 face = areBoxes(a, b) ? directionOfBoxes(a, b) : btVector3(0, 0, 0);
        if (!face.isZero())
        {
            look(tolerance, a, b, face, false);
            return;
        }
        // Which mostly does, and costs a fifth.
        look(tolerance, a, b, directionOfMiddles(a, b), false);
        if (freeTime() < kUnlimited && areConvex(a, b) && !areBoxes(a, b))
        {
            look(tolerance, a, b, directionOfCores(a, b), false);
        }
    }
    else
    {
        const bool isFirst = manifolds[0]->getBody0() == a.m_object;
        look(tolerance,
             a,
             b,
             (isFirst ? btScalar(-1) : btScalar(1)) * deepest->m_normalWorldOnB,
             touches);
    }
}

/// @param normal from A to B
void btCcdApproach::look(double tolerance,
                         const btCcdTracked& a,
                         const btCcdTracked& b,
                         const btVector3& normal,
                         bool touches)
{
    // Directions are known to the precision of Bullet only.
    if (!(btFabs(normal.length2() - btScalar(1)) < btScalar(1e-3)))
    {
        return;
    }
    const btVector3 along = normal.normalized();
    // What askStock() and askShell() leave to those that touch.
    const double shell = isMesh(*a.m_collisionShape) || isMesh(*b.m_collisionShape)
                             ? std::max(marginOf(a) + marginOf(b), btCcdManifolds::kLeastShell)
                             : 0.0;
    const double sunk =
        touches ? (1.0 - kKeptDepth) * (a.outline().m_depth + b.outline().m_depth) : 0.0;
    const double kept = shell > 0.0 ? (touches ? kTouchingShell : kFreeShell) * shell
                                    : kKeptTolerances * tolerance - sunk;
    const std::array sides{Side(a, along), Side(b, -along)};
    const double present = -kept - sides[0].support() - sides[1].support();
    // Of the two towards each other, from now on.
    const double shift = sides[0].speed() + sides[1].speed();
    if (std::max(sides[0].turn(m_remaining), sides[1].turn(m_remaining)) > kMostTurn)
    {
        m_gap = m_end = -1.0;
        return;
    }
    m_bend = sides[0].bend(m_remaining) + sides[1].bend(m_remaining);
    m_rate = sides[0].turning() + sides[1].turning();
    // How the present gap becomes smaller, at most: forward, or backward where the motion is done.
    const double closing = m_rate + (m_isDone ? -shift : shift);
    m_rate += shift;
    double other = present - std::max(0.0, closing) * m_remaining;
    if (!(other > 0.0) || m_bend == 0.0)
    {
        const double time = m_isDone ? -m_remaining : m_remaining;
        other = present - shift * time - sides[0].growth(time) - sides[1].growth(time);
    }
    else
    {
        m_bend = 0.0;  // at no time of the step are they nearer than this
    }
    m_gap = m_isDone ? other : present;
    m_end = m_isDone ? present : other;
}

double btCcdApproach::freeTime() const
{
    if (std::min(m_gap, m_end) > m_bend)
    {
        return kUnlimited;
    }
    // The rate is too small only by rounding where it is not positive.
    return m_isDone || !(m_gap > 0.0) || !(m_rate > 0.0) ? 0.0
                                                         : std::min(m_gap / m_rate, m_remaining);
}
