#include "bullet_ccd/bullet/btCcdTracker.h"

#include "bullet_ccd/bullet/btCcdContext.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
constexpr double kNever = std::numeric_limits<double>::infinity();
/// What a shape may use up of the margin of the mesh that it meets.
constexpr double kPartnersShare = btCcdShareOfMargin;
/// A list of neighbours is good for about so many steps, and for this part of an object's reach.
constexpr double kSteps = 8.0;
constexpr double kPartOfReach = 0.25;

int revisionOf(const btCollisionShape& shape)
{
    return shape.isCompound() ? static_cast<const btCompoundShape&>(shape).getUpdateRevision() : 0;
}

/// True if Bullet moves the object in a step.
bool isMoved(const btCollisionObject& object)
{
    return object.isActive() && (!object.isStaticObject() || object.isKinematicObject()) &&
           object.hasContactResponse() && object.getBroadphaseHandle() != nullptr;
}

double norm(const btVector3& v)
{
    return double(v.length());
}

/// A link's collider may not be where its joints are.
const btVector3& originOf(const btCollisionObject& object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    if (collider == nullptr)
    {
        return object.getWorldTransform().getOrigin();
    }
    const btMultiBody& body = *collider->m_multiBody;
    return collider->m_link < 0 ? body.getBasePos()
                                : body.getLink(collider->m_link).m_cachedWorldTransform.getOrigin();
}

bool isSimpleType(int type)
{
    return type == BOX_SHAPE_PROXYTYPE || type == SPHERE_SHAPE_PROXYTYPE ||
           type == CAPSULE_SHAPE_PROXYTYPE;
}
}  // namespace

btCcdKnownShape::btCcdKnownShape(const btCollisionShape& shape)
    : m_shape(&shape), m_type(shape.getShapeType()), m_isSimple(isSimpleType(m_type))
{
    if (m_isSimple)
    {
        const auto& simple = static_cast<const btConvexInternalShape&>(shape);
        m_dimensions = simple.getImplicitShapeDimensions();
        m_scaling = simple.getLocalScalingNV();
        m_margin = simple.getMarginNV();
        return;
    }
    m_scaling = shape.getLocalScaling();
    m_margin = shape.getMargin();
    m_revision = revisionOf(shape);
}

bool btCcdKnownShape::isOf(const btCollisionShape& shape) const
{
    if (m_shape != &shape || m_type != shape.getShapeType())
    {
        return false;
    }
    if (m_isSimple)
    {
        // The scaling matters to a sphere only; to the others it is in the dimensions.
        const auto& simple = static_cast<const btConvexInternalShape&>(shape);
        const btVector3& dimensions = simple.getImplicitShapeDimensions();
        return m_dimensions.x() == dimensions.x() && m_dimensions.y() == dimensions.y() &&
               m_dimensions.z() == dimensions.z() &&
               m_scaling.x() == simple.getLocalScalingNV().x() && m_margin == simple.getMarginNV();
    }
    return m_scaling == shape.getLocalScaling() && m_margin == shape.getMargin() &&
           m_revision == revisionOf(shape);
}

void btCcdTracked::take(const btCcdCourse& course, double time, double remaining)
{
    m_shift += m_course.m_velocity * btScalar(time - m_since);
    m_turned += m_course.m_turning * (time - m_since);
    m_since = time;
    m_course = course;
    m_motion = remaining * (norm(course.m_velocity) + course.m_turning);
}

btCcdTracker::btCcdTracker(btCollisionWorld& world)
    : m_world(world), m_context(btCcdContext::of(*world.getDispatcher()))
{
}

void btCcdTracker::setEnabled(const btCollisionObject* object, bool enabled)
{
    if (enabled)
    {
        m_disabled.erase(object);
    }
    else
    {
        m_disabled.insert(object);
    }
    m_isStale = true;
}

btCcdTracked* btCcdTracker::find(const btCollisionObject& object)
{
    const auto index = std::size_t(object.getWorldArrayIndex());
    return index < m_objects.size() && m_objects[index].m_object == &object ? &m_objects[index]
                                                                            : nullptr;
}

void btCcdTracker::lookAtShape(btCcdKnownShape& known)
{
    const btCollisionShape& shape = *known.m_shape;
    if (const auto simple = btCcdSimpleOutline(shape))
    {
        known.m_covered = true;
        known.m_outline = *simple;
    }
    else if (const btCcdShapeModel* model = m_context.model(&shape))
    {
        known.m_covered = true;
        known.m_outline = btCcdOutlineOf(*model);
    }
    if (known.m_covered)
    {
        known.m_extent = btCcdExtentOf(shape);
        known.m_shell = known.m_outline.m_hasMesh ? 2.0 * double(shape.getMargin()) : 0.0;
        if (known.m_outline.m_hasMesh && shape.isCompound())
        {
            known.m_shell = kNever;  // the margins are its children's
        }
    }
}

void btCcdTracker::lookAt(btCcdTracked& tracked, btCollisionObject& object)
{
    tracked = {};
    tracked.m_object = &object;
    tracked.m_collisionShape = object.getCollisionShape();
    std::unique_ptr<btCcdKnownShape>& shape = m_shapes[tracked.m_collisionShape];
    if (shape == nullptr)
    {
        shape = std::make_unique<btCcdKnownShape>(*tracked.m_collisionShape);
        lookAtShape(*shape);
        shape->m_epoch = m_epoch;
    }
    tracked.m_shape = shape.get();
    tracked.m_usable = shape->m_covered && isEnabled(&object);
    m_unsupported += shape->m_covered ? 0 : 1;
}

void btCcdTracker::lookAtAll()
{
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    m_isStale = false;
    m_neighbours.clear();
    m_shapes.clear();
    m_unsupported = 0;
    m_objects.resize(std::size_t(objects.size()));
    double ownMargin = kNever;
    for (int i = 0; i < objects.size(); ++i)
    {
        lookAt(m_objects[std::size_t(i)], *objects[i]);
        ownMargin = std::min(ownMargin, m_objects[std::size_t(i)].outline().m_ownMargin);
    }
    for (btCcdTracked& tracked : m_objects)
    {
        const btCcdShapeOutline& outline = tracked.outline();
        // Half of what a mesh can lose is its partner's.
        tracked.m_slow = kUnseen * std::min(outline.m_reserve, kPartnersShare * ownMargin);
        // A convex shape may meet a mesh of stock Bullet, which has nothing to lose.
        const bool hasNothing = outline.m_hasMesh && outline.m_ownMargin == kNever;
        tracked.m_unseen = hasNothing ? 0.0 : tracked.m_slow;
    }
}

inline bool btCcdTracker::isAsSeen(btCcdTracked& tracked, const btCollisionObject& object) const
{
    if (tracked.m_object != &object || tracked.m_collisionShape != object.getCollisionShape())
    {
        return false;
    }
    if (tracked.m_shape->m_epoch == m_epoch)
    {
        return true;
    }
    tracked.m_shape->m_epoch = m_epoch;
    return tracked.m_shape->isOf(*tracked.m_collisionShape);
}

bool btCcdTracker::look(double timeStep)
{
    m_timeStep = timeStep;
    ++m_epoch;
    forgetBodies();
    if (m_touched)
    {
        clearStep();
    }
    if (m_isStale || !readMotions(true))
    {
        lookAtAll();
        (void)readMotions(false);
    }
    findPressed();
    return m_beyondTwo > 0.0 || m_touched;
}

void btCcdTracker::clearStep()
{
    m_touched = false;
    m_pressedPairs.clear();
    for (btCcdTracked& tracked : m_objects)
    {
        tracked.m_fast = tracked.m_changed = tracked.m_pressed = tracked.m_stopped = false;
        tracked.m_since = tracked.m_turned = 0.0;
        tracked.m_shift.setZero();
    }
}

/// False if some object or shape is not the one that was seen before. Two objects of which the
/// motions beyond what they may move unseen are not positive together cannot cross.
bool btCcdTracker::readMotions(bool check)
{
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    const auto count = std::size_t(objects.size());
    if (m_objects.size() != count)
    {
        return false;
    }
    double most = -kNever;
    double second = -kNever;
    for (std::size_t i = 0; i < count; ++i)
    {
        btCcdTracked& tracked = m_objects[i];
        const btCollisionObject& object = *objects[int(i)];
        if (check && !isAsSeen(tracked, object))
        {
            return false;
        }
        if (!tracked.m_usable)
        {
            continue;
        }
        tracked.m_moves = isMoved(object);
        tracked.m_motion = tracked.m_moves ? motionOf(tracked) : 0.0;
        tracked.m_beyond = tracked.m_motion - tracked.m_unseen;
        second = std::max(second, std::min(most, tracked.m_beyond));
        most = std::max(most, tracked.m_beyond);
    }
    m_beyondTwo = most + second;
    return true;
}

inline double btCcdTracker::motionOf(const btCcdTracked& tracked)
{
    const double reach = tracked.outline().m_reach;
    if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
    {
        return m_timeStep *
               (norm(body->getLinearVelocity()) + norm(body->getAngularVelocity()) * reach);
    }
    const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
    if (collider == nullptr)
    {
        return 0.0;
    }
    const Speeds& speeds = speedsOf(*collider->m_multiBody);
    const std::size_t link = 2 * std::size_t(collider->m_link + 1);
    return speeds.m_covered ? m_timeStep * (speeds.m_links[link] + speeds.m_links[link + 1] * reach)
                            : 0.0;
}

btCcdCourse btCcdTracker::courseOf(const btCcdTracked& tracked)
{
    btCcdCourse course;
    if (tracked.m_stopped)
    {
        return course;
    }
    const double reach = tracked.outline().m_reach;
    if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
    {
        course.m_velocity = body->getLinearVelocity();
        course.m_spin = body->getAngularVelocity();
        course.m_turning = norm(course.m_spin) * reach;
        return course;
    }
    const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
    if (collider == nullptr)
    {
        return course;
    }
    const Speeds& speeds = speedsOf(*collider->m_multiBody);
    const std::size_t link = 2 * std::size_t(collider->m_link + 1);
    if (speeds.m_covered)
    {
        course.m_turning = speeds.m_links[link] + speeds.m_links[link + 1] * reach;
        if (!speeds.m_body->hasFixedBase() && speeds.m_links[0] > 0.0)
        {
            // All links have the velocity of the base, and that of their joints besides.
            course.m_velocity = speeds.m_body->getBaseVel();
            course.m_turning -= speeds.m_links[0];
        }
    }
    return course;
}

const btCcdTracker::Speeds& btCcdTracker::speedsOf(const btMultiBody& body)
{
    // Colliders of a body usually follow each other.
    if (m_lastBody != nullptr && m_lastBody->m_body == &body)
    {
        return *m_lastBody;
    }
    const auto end = m_bodies.begin() + std::ptrdiff_t(m_bodyCount);
    const auto seen = std::find_if(
        m_bodies.begin(), end, [&](const auto& known) { return known->m_body == &body; });
    if (seen != end)
    {
        m_lastBody = seen->get();
        return *m_lastBody;
    }
    if (m_bodyCount == m_bodies.size())
    {
        m_bodies.push_back(std::make_unique<Speeds>());
    }
    Speeds& speeds = *m_bodies[m_bodyCount++];
    m_lastBody = &speeds;
    speeds.m_body = &body;
    speeds.m_covered = btCcdIsCovered(body);
    if (speeds.m_covered)
    {
        btCcdReadSpeeds(body, m_timeStep, speeds.m_links);
    }
    return speeds;
}

/// Notes the pairs that the solver has let sink in deeper than slow motion leaves room for.
void btCcdTracker::findPressed()
{
    btDispatcher& dispatcher = *m_world.getDispatcher();
    btPersistentManifold** manifolds = dispatcher.getInternalManifoldPointer();
    const int count = dispatcher.getNumManifolds();
    for (int i = 0; i < count; ++i)
    {
        const btPersistentManifold& manifold = *manifolds[i];
        btScalar deepest = 0;
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            deepest = std::min(deepest, manifold.getContactPoint(k).getDistance());
        }
        if (!(deepest < btScalar(0)))
        {
            continue;
        }
        btCcdTracked* a = find(*manifold.getBody0());
        btCcdTracked* b = find(*manifold.getBody1());
        if (a == nullptr || b == nullptr)
        {
            continue;
        }
        const double reserve =
            std::min(a->outline().m_reserve + b->outline().m_reserve,
                     std::min(a->outline().m_ownMargin, b->outline().m_ownMargin));
        if (-double(deepest) > (1.0 - kUnseen) * reserve)
        {
            m_pressedPairs.push_back(
                std::minmax(int(a - m_objects.data()), int(b - m_objects.data())));
            a->m_pressed = b->m_pressed = m_touched = true;
        }
    }
}

bool btCcdTracker::isPressed(int a, int b) const
{
    return m_objects[std::size_t(a)].m_pressed && m_objects[std::size_t(b)].m_pressed &&
           std::find(m_pressedPairs.begin(), m_pressedPairs.end(), std::pair(a, b)) !=
               m_pressedPairs.end();
}

/// Of what moves, a box about its origin in which it may turn as it likes.
btCcdBox btCcdTracker::placeOf(const btCcdTracked& tracked) const
{
    if (!tracked.m_moves)
    {
        const btBroadphaseProxy& proxy = *tracked.m_object->getBroadphaseHandle();
        return {proxy.m_aabbMin, proxy.m_aabbMax};
    }
    const auto around =
        btScalar(tracked.outline().m_reach + m_context.m_tolerance + tracked.m_motion);
    const btVector3 half(around, around, around);
    const btVector3& origin = originOf(*tracked.m_object);
    return {origin - half, origin + half};
}

/// Reads what is needed to compare motions. False if an object has left its box of the list.
bool btCcdTracker::readCourses()
{
    bool inside = m_context.m_tolerance == m_listedTolerance;
    for (std::size_t i = 0; i < m_objects.size(); ++i)
    {
        btCcdTracked& tracked = m_objects[i];
        if (!tracked.m_usable)
        {
            continue;
        }
        if (!tracked.m_moves)
        {
            tracked.m_tracked = tracked.m_object->getBroadphaseHandle() != nullptr;
            tracked.m_course = {};
            inside = inside && (!tracked.m_tracked || m_neighbours.contains(i, placeOf(tracked)));
            continue;
        }
        tracked.m_course = courseOf(tracked);
        const btVector3 moved = (originOf(*tracked.m_object) - tracked.m_listed).absolute();
        const double farthest = double(std::max(std::max(moved.x(), moved.y()), moved.z()));
        tracked.m_tracked = true;
        if (!(farthest + tracked.m_motion <= tracked.m_room))
        {
            inside = false;
            const btVector3& origin = originOf(*tracked.m_object);
            tracked.m_tracked = std::isfinite(tracked.m_motion + double(origin.length2()));
        }
    }
    return inside;
}

void btCcdTracker::listNeighbours()
{
    m_boxes.clear();
    m_listedTolerance = m_context.m_tolerance;
    for (btCcdTracked& tracked : m_objects)
    {
        tracked.m_room = -1.0;
        btCcdBox box = tracked.m_tracked ? placeOf(tracked) : btCcdBox{};
        if (tracked.m_tracked && tracked.m_moves)
        {
            const auto room = btScalar(
                std::max(kSteps * tracked.m_motion, kPartOfReach * tracked.outline().m_reach));
            box.m_low -= btVector3(room, room, room);
            box.m_high += btVector3(room, room, room);
            tracked.m_room = tracked.m_motion + double(room);
            tracked.m_listed = originOf(*tracked.m_object);
        }
        m_boxes.push_back(box);
    }
    m_neighbours.list(m_boxes);
}

const std::vector<std::pair<int, int>>& btCcdTracker::findNeighbours()
{
    if (!readCourses())
    {
        listNeighbours();
    }
    return m_neighbours.pairs();
}
