#include "bullet_ccd/bullet/step/btCcdTracker.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace
{
constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// Objects that leave the boxes that they have in the broadphase: so many, and one of so
/// many. What is nearer than so many tolerances to a box counts as inside.
constexpr std::size_t kFewStrays = 16;
constexpr std::size_t kObjectsOfStray = 4;
constexpr double kTolerances = 2.0;
/// Of which the sine is the angle, all but a fourth of its third power [rad].
constexpr double kSmallTurn = 0.45;
/// What a shape may use up of the margin of the mesh that it meets.
constexpr double kPartnersShare = btCcdShareOfMargin;
/// A list of neighbours is good for this part of an object's reach at least. It is good for fewer
/// steps if it had more pairs than so many of an object, and some.
constexpr double kPartOfReach = 0.35;
constexpr double kPartOfReachOfFew = 1.0;
constexpr std::size_t kPairsOfObject = 16;
constexpr std::size_t kMorePairs = 1024;
/// A list of too many pairs is made anew for so many times fewer steps, and not for more again
/// before so many others: one that is given up costs as much as a good one.
constexpr double kTooManyPairs = 8.0;
constexpr int kPatience = 4;
constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();
constexpr double kFarthest = 1e15;
/// So many objects, at most, say what most objects do.
constexpr std::size_t kSample = 33;
/// Of what exact contacts say is left before two meshes meet: what counts.
constexpr double kTrusted = 0.9;
constexpr double kAsk = -1.0;  // however little the two move
/// So many are not worth being compared all at once, and of so many all pairs are quickly looked
/// through.
constexpr std::size_t kVeryFew = 4;
constexpr std::size_t kQuicklyLooked = 12;

double lengthOf(const btVector3& v)
{
    return double(v.length());
}

/// A convex shape that meets it may lose its own depth alone.
bool isStockMesh(const btCcdTracked& tracked)
{
    return tracked.outline().m_hasMesh && tracked.outline().m_ownMargin == kUnbounded;
}

/// Of two whose contacts are exact and are where the two are; otherwise these do not tell.
double leftOver(const btCcdTracked& a, const btCcdTracked& b, double depth)
{
    const btCcdShapeOutline& outlineA = a.outline();
    const btCcdShapeOutline& outlineB = b.outline();
    if (!outlineA.m_isOwn || !outlineB.m_isOwn || a.m_way != nullptr || b.m_way != nullptr)
    {
        return kAsk;
    }
    const double margins = outlineA.m_ownMargin + outlineB.m_ownMargin;
    return kTrusted * btCcdReserveOfMargin * margins - depth;
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

/// By its bits: this is asked of every body in every step.
inline bool isNotZero(btScalar value)
{
    using Bits = std::conditional_t<sizeof(btScalar) == 8, std::uint64_t, std::uint32_t>;
    return std::bit_cast<Bits>(value) != 0;
}

/// Of each coordinate.
btVector3 medianOf(std::vector<btVector3>& vectors)
{
    btVector3 median(0, 0, 0);
    const std::size_t half = vectors.size() / 2;
    for (int k = 0; k < 3 && !vectors.empty(); ++k)
    {
        std::nth_element(vectors.begin(),
                         vectors.begin() + std::ptrdiff_t(half),
                         vectors.end(),
                         [k](const btVector3& a, const btVector3& b) { return a[k] < b[k]; });
        median[k] = vectors[half][k];
    }
    return median;
}

double farthestAlongAxes(const btVector3& v)
{
    const btVector3 way = v.absolute();
    return double(way[way.maxAxis()]);
}

/// Null if neither is the other's parent.
const btMultiBodyLinkCollider* childOf(const btCollisionObject& a, const btCollisionObject& b)
{
    const auto* linkA = btMultiBodyLinkCollider::upcast(&a);
    const auto* linkB = btMultiBodyLinkCollider::upcast(&b);
    if (linkA == nullptr || linkB == nullptr || linkA->m_multiBody != linkB->m_multiBody)
    {
        return nullptr;
    }
    for (const auto& [child, parent] : {std::pair(linkA, linkB), std::pair(linkB, linkA)})
    {
        if (child->m_link >= 0 &&
            child->m_multiBody->getLink(child->m_link).m_parent == parent->m_link)
        {
            return child;
        }
    }
    return nullptr;
}
}  // namespace

void btCcdTracked::take(const btCcdCourse& course, double time, double remaining)
{
    m_shift += m_course.m_velocity * btScalar(time - m_since);
    m_turned += m_course.m_turning * (time - m_since);
    m_since = time;
    m_course = course;
    m_motion = remaining * (lengthOf(course.m_velocity) + course.m_turning);
}

btCcdTracker::btCcdTracker(btCollisionWorld& world)
    : m_world(world), m_context(btCcdContext::of(*world.getDispatcher()))
{
}

const btCcdTracked* btCcdTracker::find(const btCollisionObject& object) const
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
        known.m_isMissed = model->m_uncovered != nullptr;
        known.m_outline = btCcdOutlineOf(*model);
    }
    else
    {
        known.m_isMissed = !btCcdContext::needsNoModel(shape);
    }
    if (known.m_covered)
    {
        known.m_extent = btCcdExtentOf(shape);
        known.m_shell = known.m_outline.m_hasMesh ? 2.0 * double(shape.getMargin()) : 0.0;
        if (known.m_outline.m_hasMesh && shape.isCompound())
        {
            known.m_shell = kUnbounded;  // the margins are its children's
        }
    }
}

void btCcdTracker::lookAt(btCcdTracked& tracked, btCollisionObject& object)
{
    tracked = {};
    tracked.m_object = &object;
    tracked.m_collisionShape = object.getCollisionShape();
    const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
    tracked.m_proxy = proxy != nullptr ? proxy->m_uniqueId : 0;
    const auto [seen, isNew] = m_proxies.try_emplace(&object, tracked.m_proxy);
    if (isNew || seen->second != tracked.m_proxy)
    {
        seen->second = tracked.m_proxy;
        m_ways.erase(&object);
        m_context.m_shapes.check(tracked.m_collisionShape);
    }
    std::unique_ptr<btCcdKnownShape>& shape = m_shapes[tracked.m_collisionShape];
    if (shape == nullptr)
    {
        shape = std::make_unique<btCcdKnownShape>(*tracked.m_collisionShape);
        lookAtShape(*shape);
        shape->m_epoch = m_epoch;
    }
    tracked.m_shape = shape.get();
    m_context.checkPose(object);
    const btCcdMode mode = m_context.m_objects.of(&object).m_mode;
    tracked.m_usable = shape->m_covered && mode != btCcdMode::Off;
    tracked.m_turns =
        mode == btCcdMode::Full || btMultiBodyLinkCollider::upcast(&object) != nullptr;
    m_unsupported += shape->m_isMissed ? 1 : 0;
}

void btCcdTracker::lookAtAll()
{
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    m_isStale = false;
    m_restList.m_boxes.clear();
    m_moverList.m_boxes.clear();
    m_movers.clear();
    m_others.clear();
    m_strays.clear();
    m_isAlongListed = false;
    m_group.clear();
    m_moverCount = 0;
    m_shapes.clear();
    m_unsupported = 0;
    if (m_proxies.size() > 2 * std::size_t(objects.size()))
    {
        m_proxies.clear();
    }
    m_objects.resize(std::size_t(objects.size()));
    double ownMargin = kUnbounded;
    for (int i = 0; i < objects.size(); ++i)
    {
        lookAt(m_objects[std::size_t(i)], *objects[i]);
        ownMargin = std::min(ownMargin, m_objects[std::size_t(i)].outline().m_ownMargin);
    }
    m_moversMayLose = kUnbounded;
    m_beyondAtRest = -kUnbounded;
    m_listsAll = false;
    m_hasStockMeshes = false;
    bool hasLinks = false;
    for (btCcdTracked& tracked : m_objects)
    {
        const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
        hasLinks = hasLinks || (collider != nullptr && collider->m_link >= 0);
        const btCcdShapeOutline& outline = tracked.outline();
        const bool isStock = !outline.m_hasMesh && outline.m_ownMargin == kUnbounded;
        m_moversMayLose =
            std::min(m_moversMayLose, isStock ? 2.0 * kUnseen * outline.m_depth : 0.0);
        // Half of what a mesh can lose is its partner's.
        tracked.m_slow = kUnseen * std::min(outline.m_reserve, kPartnersShare * ownMargin);
        // A convex shape may meet a mesh of stock Bullet, which has nothing to lose.
        const bool hasNothing = isStockMesh(tracked);
        m_hasStockMeshes = m_hasStockMeshes || hasNothing;
        tracked.m_unseen = hasNothing ? 0.0 : tracked.m_slow;
        tracked.m_beyond = -tracked.m_unseen;
        m_beyondAtRest = std::max(m_beyondAtRest, tracked.m_beyond);
    }
    // Links move relative to each other more than it seems from their speeds.
    m_compares = !hasLinks && m_objects.size() > kVeryFew;
}

inline bool btCcdTracker::isAsSeen(btCcdTracked& tracked, const btCollisionObject& object) const
{
    if (tracked.m_object != &object || tracked.m_collisionShape != object.getCollisionShape())
    {
        return false;
    }
    const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
    if (proxy != nullptr && proxy->m_uniqueId != tracked.m_proxy)
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

/// True for the one object of a world, which meets nothing.
bool btCcdTracker::isAlone() const
{
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    return objects.size() == 1 && !m_isStale && !m_touched && m_objects[0].m_object == objects[0] &&
           m_objects[0].m_collisionShape == objects[0]->getCollisionShape();
}

void btCcdTracker::prepare()
{
    lookAtAll();
    for (const auto& [shape, known] : m_shapes)
    {
        if (btCcdSimpleOutline(*shape))
        {
            (void)m_context.model(shape);
        }
    }
}

bool btCcdTracker::look(double timeStep, bool kinematicStands)
{
    m_kinematicStands = kinematicStands;
    if (m_objects.size() == 1 && isAlone())
    {
        return false;
    }
    m_timeStep = timeStep;
    ++m_epoch;
    forgetBodies();
    forgetStrays();
    if (m_touched)
    {
        clearStep();
    }
    if (m_isStale || !readMotions(true))
    {
        lookAtAll();
        (void)readMotions(false);
    }
    if (const int count = m_world.getDispatcher()->getNumManifolds(); count > 0)
    {
        findPressed(m_world.getDispatcher()->getInternalManifoldPointer(), count);
    }
    if (!m_deepPairs.empty())
    {
        pressDeep();
    }
    return m_beyondTwo > 0.0 || m_touched;
}

void btCcdTracker::clearStep()
{
    m_touched = false;
    m_pressedPairs.clear();
    for (btCcdTracked& tracked : m_objects)
    {
        tracked.m_fast = tracked.m_changed = tracked.m_pressed = tracked.m_stopped = false;
        tracked.m_squeezed = false;
        tracked.m_since = tracked.m_turned = 0.0;
        tracked.m_shift.setZero();
        if (!tracked.m_moves)
        {
            tracked.m_motion = 0.0;
            tracked.m_course = {};
        }
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
    m_isClamped = false;
    int flags = 0;  // of any object
    const double tolerance = m_context.m_tolerance;
    bool listed = tolerance == m_listedTolerance;
    double most = m_beyondAtRest;
    double second = m_beyondAtRest;
    const btCollisionObject* const* next = count > 0 ? &objects[0] : nullptr;
    btCcdTracked* tracked = m_objects.data();
    for (const btCcdTracked* end = tracked + count; tracked != end; ++tracked)
    {
        const btCollisionObject& object = **next++;
        if (check && !isAsSeen(*tracked, object))
        {
            return false;
        }
        flags |= object.getCollisionFlags();
        if (!tracked->m_usable)
        {
            continue;
        }
        if (!btCcdIsMoved(object))
        {
            listed = readAtRest(*tracked) && listed;
            continue;
        }
        listed = read(*tracked, tolerance) && listed;
        second = std::max(second, std::min(most, tracked->m_beyond));
        most = std::max(most, tracked->m_beyond);
    }
    m_hasTriggers = (flags & btCollisionObject::CF_NO_CONTACT_RESPONSE) != 0;
    m_isListed = listed;
    m_beyondTwo = most + second;
    m_apart = kUnbounded;
    if (m_compares && m_beyondTwo > 0.0)
    {
        compareMotions();
    }
    return true;
}

/// How far any two rigid bodies get from each other in the step, at most. Of what moves along with
/// a kinematic object Bullet's contacts say little: it is ahead of the others there.
void btCcdTracker::compareMotions()
{
    const btCcdTracked* reference = nullptr;
    double most = 0.0;
    double second = 0.0;
    for (const btCcdTracked& tracked : m_objects)
    {
        if (!tracked.m_moves && !tracked.m_isMover)
        {
            continue;
        }
        if (tracked.m_way != nullptr && tracked.farthest() > m_moversMayLose)
        {
            return;
        }
        reference = reference == nullptr ? &tracked : reference;
        const btCcdCourse& course = tracked.m_course;
        const double apart =
            lengthOf(course.m_velocity - reference->m_course.m_velocity) + course.m_turning;
        second = std::max(second, std::min(most, apart));
        most = std::max(most, apart);
    }
    m_apart = m_timeStep * (most + second);
}

/// These two are false if the object is not where the list of neighbours has it.
inline bool btCcdTracker::readAtRest(btCcdTracked& tracked)
{
    if (tracked.m_moves)
    {
        tracked.m_moves = false;
        tracked.m_motion = 0.0;
        tracked.m_beyond = -tracked.m_unseen;
        tracked.m_course = {};
        tracked.m_way = nullptr;
    }
    if (tracked.m_object->isKinematicObject()) [[unlikely]]
    {
        if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
        {
            m_ways[body].rest(*body, m_step);
        }
    }
    const btBroadphaseProxy* proxy = tracked.m_object->getBroadphaseHandle();
    tracked.m_tracked = proxy != nullptr;
    if (tracked.m_isMover)
    {
        tracked.m_origin = originOf(*tracked.m_object);
        return isInside(tracked);
    }
    return m_listsAll || proxy == nullptr ||
           (tracked.m_listedBox != nullptr &&
            tracked.m_listedBox->contains(proxy->m_aabbMin, proxy->m_aabbMax));
}

/// Where the object is and how it moves. Called once for every body in every step.
[[gnu::always_inline]] inline bool btCcdTracker::read(btCcdTracked& tracked, double tolerance)
{
    const double reach = tracked.outline().m_reach;
    tracked.m_moves = true;
    if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
    {
        btCcdCourse& course = tracked.m_course;
        course.m_velocity = body->getLinearVelocity();
        course.m_turning = tracked.m_turns ? lengthOf(body->getAngularVelocity()) * reach : 0.0;
        tracked.m_motion = m_timeStep * (lengthOf(course.m_velocity) + course.m_turning);
        tracked.m_beyond = tracked.m_motion - tracked.m_unseen;
        tracked.m_origin = body->getWorldTransform().getOrigin();
        tracked.m_way = nullptr;
        if (isNotZero(body->getCcdMotionThreshold())) [[unlikely]]
        {
            m_isClamped = true;
        }
        if (body->isKinematicObject()) [[unlikely]]
        {
            readKinematic(tracked);
        }
    }
    else if (const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object))
    {
        readLink(tracked, *collider);
        tracked.m_beyond = tracked.m_motion - tracked.m_unseen;
    }
    else
    {
        tracked.m_course = {};
        tracked.m_motion = 0.0;
        tracked.m_beyond = -tracked.m_unseen;
        tracked.m_origin = tracked.m_object->getWorldTransform().getOrigin();
    }
    tracked.m_around = reach + tolerance + tracked.m_motion;
    // What moves is in a list of all pairs wherever it is.
    const bool isListed = m_listsAll && tracked.m_isMover;
    if (!isListed && isInside(tracked))
    {
        tracked.m_tracked = true;
        return true;
    }
    tracked.m_tracked = std::isfinite(tracked.m_motion + double(tracked.m_origin.length2()));
    return isListed || !tracked.m_tracked;
}

inline bool btCcdTracker::isInside(const btCcdTracked& tracked)
{
    const btVector3& origin = tracked.m_listed.m_origin;
    const double room = tracked.m_listed.m_room - tracked.m_motion;
    // NaN is in no room.
    return std::abs(double(tracked.m_origin.x() - origin.x())) <= room &&
           std::abs(double(tracked.m_origin.y() - origin.y())) <= room &&
           std::abs(double(tracked.m_origin.z() - origin.z())) <= room;
}

/// The part of its way that it covers in this step.
void btCcdTracker::readKinematic(btCcdTracked& tracked)
{
    const double reach = tracked.outline().m_reach;
    btCcdWay& way = m_ways[tracked.m_object];
    way.go(*btRigidBody::upcast(tracked.m_object),
           {.m_number = m_step,
            .m_duration = m_timeStep,
            .m_rounding = m_context.m_tolerance,
            .m_reach = reach,
            .m_isTold = m_teleported.count(tracked.m_object) != 0});
    tracked.m_way = &way;
    tracked.m_jumped = way.m_jumped;
    tracked.m_origin = way.m_start.getOrigin();
    tracked.m_course = courseOf(tracked);
    tracked.m_motion =
        m_timeStep * (lengthOf(tracked.m_course.m_velocity) + tracked.m_course.m_turning);
    tracked.m_beyond = tracked.farthest() - tracked.m_unseen;
}

void btCcdTracker::noteEnd()
{
    if (!m_teleported.empty())
    {
        m_teleported.clear();
    }
    if (!m_ways.empty())
    {
        std::erase_if(m_ways, [this](const auto& known) { return known.second.m_step < m_step; });
    }
    if (m_hasStockMeshes)
    {
        for (btCcdTracked& tracked : m_objects)
        {
            const double way = lengthOf(tracked.m_shift) + tracked.m_turned + tracked.m_motion;
            tracked.m_crept = tracked.m_isDue ? 0.0 : tracked.m_crept + way;
            tracked.m_isDue = false;
        }
    }
}

inline void btCcdTracker::readLink(btCcdTracked& tracked, const btMultiBodyLinkCollider& collider)
{
    const Speeds& speeds = speedsOf(*collider.m_multiBody);
    btCcdCourse& course = tracked.m_course;
    tracked.m_origin = originOf(collider);
    tracked.m_motion = course.m_turning = 0.0;
    course.m_velocity = speeds.m_velocity;
    if (speeds.m_covered)
    {
        const double* link = &speeds.m_links[2 * std::size_t(collider.m_link + 1)];
        const double speed = link[0] + link[1] * tracked.outline().m_reach;
        tracked.m_motion = m_timeStep * speed;
        course.m_turning = speed - speeds.m_common;
    }
}

btCcdCourse btCcdTracker::courseOf(const btCcdTracked& tracked)
{
    btCcdCourse course;
    if (tracked.m_stopped || tracked.m_jumped || (m_kinematicStands && tracked.m_way != nullptr))
    {
        return course;
    }
    const double reach = tracked.outline().m_reach;
    if (const btCcdWay* way = tracked.m_way)
    {
        const double turning = tracked.m_turns ? lengthOf(way->m_spin) * reach : 0.0;
        return {way->m_velocity, way->m_spin, turning};
    }
    if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
    {
        course.m_velocity = body->getLinearVelocity();
        course.m_spin = body->getAngularVelocity();
        course.m_turning = tracked.m_turns ? lengthOf(course.m_spin) * reach : 0.0;
        return course;
    }
    const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
    if (collider == nullptr)
    {
        return course;
    }
    const Speeds& speeds = speedsOf(*collider->m_multiBody);
    if (speeds.m_covered)
    {
        const double* link = &speeds.m_links[2 * std::size_t(collider->m_link + 1)];
        course.m_velocity = speeds.m_velocity;
        course.m_turning = link[0] + link[1] * reach - speeds.m_common;
    }
    return course;
}

const btCcdTracker::Speeds& btCcdTracker::findSpeeds(const btMultiBody& body)
{
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
    // All links have the velocity of the base, and that of their joints besides.
    const bool floats = speeds.m_covered && !body.hasFixedBase() && speeds.m_links[0] > 0.0;
    speeds.m_velocity = floats ? body.getBaseVel() : btVector3(0, 0, 0);
    speeds.m_common = floats ? speeds.m_links[0] : 0.0;
    return speeds;
}

/// True if the solver has let the two sink in deeper than slow motion leaves room for.
inline bool btCcdTracker::isPressed(const btPersistentManifold& manifold,
                                    const btCcdTracked*& a,
                                    const btCcdTracked*& b,
                                    double& left) const
{
    btScalar deepest = 0;
    for (int k = 0; k < manifold.getNumContacts(); ++k)
    {
        deepest = std::min(deepest, manifold.getContactPoint(k).getDistance());
    }
    if (!(deepest < btScalar(0)))
    {
        return false;
    }
    a = find(*manifold.getBody0());
    b = find(*manifold.getBody1());
    if (a == nullptr || b == nullptr)
    {
        return false;
    }
    const double reserve = std::min(a->outline().m_reserve + b->outline().m_reserve,
                                    std::min(a->outline().m_ownMargin, b->outline().m_ownMargin));
    left = leftOver(*a, *b, -double(deepest));
    return -double(deepest) > (1.0 - kUnseen) * reserve;
}

/// True if a convex shape that touches a stock mesh may have sunk in by as much as it may lose
/// unseen. Bullet's contacts do not tell: in single precision those of a thin shape and a large
/// triangle are off by more than that, or missing.
inline bool btCcdTracker::isDue(const btPersistentManifold& manifold,
                                const btCcdTracked*& a,
                                const btCcdTracked*& b)
{
    btCcdTracked* first = find(*manifold.getBody0());
    btCcdTracked* second = find(*manifold.getBody1());
    if (first == nullptr || second == nullptr || isStockMesh(*first) == isStockMesh(*second))
    {
        return false;
    }
    a = first;
    b = second;
    btCcdTracked& convex = isStockMesh(*first) ? *second : *first;
    const btCcdShapeOutline& outline = convex.outline();
    const double moves = a->m_motion + b->m_motion;
    if (outline.m_ownMargin != kUnbounded || !(moves > 0.0) ||
        !(convex.m_crept + moves > kUnseen * outline.m_depth))
    {
        return false;
    }
    convex.m_isDue = true;
    return true;
}

void btCcdTracker::findPressed(btPersistentManifold** manifolds, int count)
{
    for (int i = 0; i < count; ++i)
    {
        const btCcdTracked* a = nullptr;
        const btCcdTracked* b = nullptr;
        double left = kAsk;
        if (isPressed(*manifolds[i], a, b, left))
        {
            press(int(a - m_objects.data()), int(b - m_objects.data()), left);
        }
        else if (m_hasStockMeshes && isDue(*manifolds[i], a, b))
        {
            press(int(a - m_objects.data()), int(b - m_objects.data()), kAsk);
        }
    }
}

void btCcdTracker::press(int a, int b, double left)
{
    m_pressedPairs.push_back({std::minmax(a, b), left});
    m_objects[std::size_t(a)].m_pressed = true;
    m_objects[std::size_t(b)].m_pressed = true;
    m_touched = true;
}

void btCcdTracker::noteDeep(int a, int b, bool isDeep)
{
    const bool mayBeKnown =
        m_objects[std::size_t(a)].m_pressed && m_objects[std::size_t(b)].m_pressed;
    if (!isDeep && !mayBeKnown)
    {
        return;
    }
    const btCollisionObject* first = m_objects[std::size_t(a)].m_object;
    const btCollisionObject* second = m_objects[std::size_t(b)].m_object;
    using Both = std::array<const btCollisionObject*, 2>;
    const auto known = std::find_if(
        m_deepPairs.begin(),
        m_deepPairs.end(),
        [&](const DeepPair& pair) {
            return pair.m_objects == Both{first, second} || pair.m_objects == Both{second, first};
        });
    if (known != m_deepPairs.end())
    {
        if (!isDeep)
        {
            m_deepPairs.erase(known);
        }
    }
    else if (isDeep)
    {
        m_deepPairs.push_back({{a, b}, {first, second}});
        press(a, b, kAsk);
    }
}

/// The pairs that were deep when they were asked last and are still near each other.
void btCcdTracker::pressDeep()
{
    std::erase_if(m_deepPairs, [this](DeepPair& pair) { return !isThere(pair); });
    for (const DeepPair& pair : m_deepPairs)
    {
        press(pair.m_indices[0], pair.m_indices[1], kAsk);
    }
}

/// Objects change places where others have been removed.
bool btCcdTracker::isThere(DeepPair& pair) const
{
    std::array<btBroadphaseProxy*, 2> proxies{};
    for (const std::size_t k : {0, 1})
    {
        const auto isIt = [&](const btCcdTracked& tracked)
        { return tracked.m_object == pair.m_objects[k]; };
        auto index = std::size_t(pair.m_indices[k]);
        if (index >= m_objects.size() || !isIt(m_objects[index]))
        {
            index = std::size_t(std::find_if(m_objects.begin(), m_objects.end(), isIt) -
                                m_objects.begin());
        }
        if (index == m_objects.size() || !m_objects[index].m_usable ||
            m_objects[index].m_object->getBroadphaseHandle() == nullptr)
        {
            return false;
        }
        pair.m_indices[k] = int(index);
        proxies[k] = m_objects[index].m_object->getBroadphaseHandle();
    }
    return m_world.getPairCache()->findPair(proxies[0], proxies[1]) != nullptr;
}

double btCcdTracker::leftOf(int a, int b) const
{
    double left = kUnbounded;
    if (m_objects[std::size_t(a)].m_pressed && m_objects[std::size_t(b)].m_pressed)
    {
        for (const PressedPair& pair : m_pressedPairs)
        {
            left = pair.m_indices == std::pair(a, b) ? std::min(left, pair.m_left) : left;
        }
    }
    return left;
}

/// Of what moves, a box about its origin in which it may turn as it likes.
btCcdBox btCcdTracker::placeOf(const btCcdTracked& tracked) const
{
    if (!tracked.m_moves)
    {
        const btBroadphaseProxy& proxy = *tracked.m_object->getBroadphaseHandle();
        return {proxy.m_aabbMin, proxy.m_aabbMax};
    }
    const auto around = btScalar(tracked.m_around);
    const btVector3 half(around, around, around);
    return {tracked.m_origin - half, tracked.m_origin + half};
}

bool btCcdTracker::isBoxApart(const btCcdTracked& mover, const btCcdTracked& other)
{
    const auto around = btScalar(mover.m_around);
    const btBroadphaseProxy& box = *other.m_object->getBroadphaseHandle();
    const auto isOutside = [&](int axis)
    {
        return box.m_aabbMin[axis] - mover.m_origin[axis] > around ||
               mover.m_origin[axis] - box.m_aabbMax[axis] > around;
    };
    return !mover.m_moves || isOutside(0) || isOutside(1) || isOutside(2);
}

/// What moves now is listed as a mover, even if it falls asleep meanwhile.
void btCcdTracker::group()
{
    m_group.clear();
    for (const bool moves : {true, false})
    {
        for (std::size_t i = 0; i < m_objects.size(); ++i)
        {
            if (m_objects[i].m_moves == moves)
            {
                m_group.push_back(int(i));
            }
        }
        m_moverCount = moves ? m_group.size() : m_moverCount;
    }
    for (btCcdTracked& tracked : m_objects)
    {
        m_isAlongListed = m_isAlongListed && tracked.m_isMover == tracked.m_moves;
        tracked.m_isMover = tracked.m_moves;
    }
}

/// @param make makes the list, good for so many steps; false if that has more pairs than it may
template <typename Make>
void btCcdTracker::makeList(List& list, const Make& make) const
{
    const std::size_t most = kPairsOfObject * m_objects.size() + kMorePairs;
    if (list.m_patience > 0)
    {
        --list.m_patience;
    }
    else
    {
        list.m_steps = std::clamp(2.0 * list.m_steps, 1.0, kSteps);
    }
    while (!make(list.m_steps, list.m_steps > 0.0 ? most : kAnyNumber))
    {
        list.m_steps = list.m_steps > 1.0 ? list.m_steps / kTooManyPairs : 0.0;
        list.m_patience = kPatience;
    }
}

void btCcdTracker::takePairs(const List& list, std::vector<btCcdNeighbourPair>& pairs)
{
    pairs.clear();
    pairs.reserve(list.m_boxes.pairs().size());
    for (const auto& [first, second] : list.m_boxes.pairs())
    {
        if (std::size_t(first) >= m_moverCount)
        {
            continue;  // both are at rest
        }
        const std::pair<int, int> pair =
            std::minmax(m_group[std::size_t(first)], m_group[std::size_t(second)]);
        btCcdTracked& a = m_objects[std::size_t(pair.first)];
        btCcdTracked& b = m_objects[std::size_t(pair.second)];
        pairs.push_back({&a, &b, -1.0, childOf(*a.m_object, *b.m_object)});
    }
    const auto isBefore = [](const btCcdNeighbourPair& x, const btCcdNeighbourPair& y)
    { return std::pair(x.m_a, x.m_b) < std::pair(y.m_a, y.m_b); };
    if (!std::is_sorted(pairs.begin(), pairs.end(), isBefore))
    {
        std::sort(pairs.begin(), pairs.end(), isBefore);
    }
}

void btCcdTracker::listWithRest()
{
    m_listedTolerance = m_context.m_tolerance;
    m_listsAll = false;
    if (m_objects.size() <= kQuicklyLooked)
    {
        listAllPairs();
        return;
    }
    const double partOfReach = listsMoversApart() ? kPartOfReach : kPartOfReachOfFew;
    const auto make = [this, partOfReach](double steps, std::size_t most)
    {
        std::vector<btCcdBox>& boxes = m_restList.m_boxes.boxes();
        boxes.clear();
        boxes.reserve(m_objects.size());
        for (const int index : m_group)
        {
            btCcdTracked& tracked = m_objects[std::size_t(index)];
            tracked.m_listed = {};
            btCcdBox box = tracked.m_tracked ? placeOf(tracked) : btCcdBox{};
            if (tracked.m_tracked && tracked.m_moves)
            {
                const auto room = btScalar(
                    std::max(steps * tracked.m_motion, partOfReach * tracked.outline().m_reach));
                box.m_low -= btVector3(room, room, room);
                box.m_high += btVector3(room, room, room);
                tracked.m_listed = {tracked.m_origin, tracked.m_motion + double(room)};
            }
            boxes.push_back(box);  // there is room: the others stay where they are
            tracked.m_listedBox = tracked.m_moves ? nullptr : &boxes.back();
        }
        return listsMoversApart() ? m_restList.m_boxes.listBetween(m_moverCount, most)
                                  : m_restList.m_boxes.listAmongAll(most);
    };
    makeList(m_restList, make);
    takePairs(m_restList, m_others);
    if (!listsMoversApart())
    {
        splitPairs();
    }
}

/// Wherever they are, if not too far for numbers: the list is good until something moves that was
/// at rest.
void btCcdTracker::listAllPairs()
{
    m_listsAll = true;
    m_movers.clear();
    m_others.clear();
    m_movers.reserve(m_objects.size() * (m_objects.size() - 1) / 2);
    for (std::size_t i = 0; i < m_objects.size(); ++i)
    {
        btCcdTracked& a = m_objects[i];
        a.m_listed = {a.m_origin, a.m_moves ? kFarthest : -1.0};
        a.m_listedBox = nullptr;
        for (std::size_t j = i + 1; j < m_objects.size(); ++j)
        {
            btCcdTracked& b = m_objects[j];
            if (a.m_isMover || b.m_isMover)
            {
                (a.m_isMover && b.m_isMover ? m_movers : m_others)
                    .push_back({&a, &b, -1.0, childOf(*a.m_object, *b.m_object)});
            }
        }
    }
}

/// The list is of all objects.
void btCcdTracker::splitPairs()
{
    m_movers.clear();
    m_movers.reserve(m_others.size());
    std::erase_if(m_others,
                  [this](const btCcdNeighbourPair& pair)
                  {
                      const bool isOfMovers = pair.m_a->m_isMover && pair.m_b->m_isMover;
                      if (isOfMovers)
                      {
                          m_movers.push_back(pair);
                      }
                      return isOfMovers;
                  });
}

/// For few objects it is not worth the while to ask what movers have in common.
inline bool btCcdTracker::listsMoversApart() const
{
    return m_objects.size() > kSample;
}

/// Of most movers: of the middle ones of a sample, coordinate by coordinate.
btVector3 btCcdTracker::commonVelocity()
{
    m_samples.clear();
    const std::size_t stride = m_moverCount / kSample + 1;
    for (std::size_t i = 0; i < m_moverCount; i += stride)
    {
        const btCcdTracked& tracked = m_objects[std::size_t(m_group[i])];
        if (tracked.m_tracked)
        {
            m_samples.push_back(tracked.m_course.m_velocity);
        }
    }
    return medianOf(m_samples);
}

/// Bound of what any point of the object moves in the step, as seen from what moves along.
inline double btCcdTracker::motionAlong(const btCcdTracked& tracked, const btVector3& common) const
{
    return m_timeStep *
           (lengthOf(tracked.m_course.m_velocity - common) + tracked.m_course.m_turning);
}

/// True if all movers are in their boxes of the list, wherever that has moved as a whole.
bool btCcdTracker::isAlongGood(const btVector3& common)
{
    if (!m_isAlongListed)
    {
        return false;
    }
    m_samples.clear();
    const std::size_t stride = m_moverCount / kSample + 1;
    for (std::size_t i = 0; i < m_moverCount; i += stride)
    {
        const btCcdTracked& tracked = m_objects[std::size_t(m_group[i])];
        if (tracked.m_tracked)
        {
            m_samples.push_back(tracked.m_origin - tracked.m_along.m_origin);
        }
    }
    m_commonWay = medianOf(m_samples);
    return std::all_of(
        m_group.begin(),
        m_group.begin() + std::ptrdiff_t(m_moverCount),
        [&](int index)
        {
            const btCcdTracked& tracked = m_objects[std::size_t(index)];
            return !tracked.m_tracked ||
                   farthestAlongAxes(tracked.m_origin - tracked.m_along.m_origin - m_commonWay) +
                           motionAlong(tracked, common) <=
                       tracked.m_along.m_room;
        });
}

void btCcdTracker::listMovers(const btVector3& common)
{
    m_isAlongListed = true;
    m_commonWay.setZero();
    const auto make = [&](double steps, std::size_t most)
    {
        std::vector<btCcdBox>& boxes = m_moverList.m_boxes.boxes();
        boxes.assign(m_moverCount, {});
        for (std::size_t i = 0; i < m_moverCount; ++i)
        {
            btCcdTracked& tracked = m_objects[std::size_t(m_group[i])];
            tracked.m_along = {};
            if (!tracked.m_tracked)
            {
                continue;
            }
            const double reach = tracked.outline().m_reach;
            const double motion = motionAlong(tracked, common);
            const double room = motion + std::max(steps * motion, kPartOfReach * reach);
            const auto around = btScalar(reach + m_context.m_tolerance + room);
            const btVector3 half(around, around, around);
            boxes[i] = {tracked.m_origin - half, tracked.m_origin + half};
            tracked.m_along = {tracked.m_origin, room};
        }
        return m_moverList.m_boxes.listAmongAll(most);
    };
    makeList(m_moverList, make);
    takePairs(m_moverList, m_movers);
}

void btCcdTracker::forgetAllStrays()
{
    for (const int index : m_strays)
    {
        m_objects[std::size_t(index)].m_isStray = false;
    }
    m_strays.clear();
}

/// False if there are too many.
bool btCcdTracker::findStrays(bool done)
{
    // Bullet's boxes are larger than shapes; half of that may be used up by pushes.
    const double room =
        0.5 * double(gContactBreakingThreshold) - kTolerances * m_context.m_tolerance;
    const std::size_t most = kFewStrays + m_objects.size() / kObjectsOfStray;
    for (const btCollisionObject* object : m_pushable)
    {
        btCcdTracked* pushed = find(*object);
        if (pushed != nullptr && pushed->m_tracked)
        {
            stray(*pushed);
        }
    }
    for (btCcdTracked& tracked : m_objects)
    {
        if (!tracked.m_moves || !tracked.m_tracked || tracked.m_isStray)
        {
            continue;
        }
        const bool isSlow = !(tracked.m_motion > room) && tracked.m_way == nullptr &&
                            btMultiBodyLinkCollider::upcast(tracked.m_object) == nullptr;
        if (!isSlow && !staysInBox(tracked, done))
        {
            stray(tracked);
            if (m_strays.size() > most)
            {
                return false;
            }
        }
    }
    return true;
}

/// True if the box that the object has in the broadphase is about all of its path in the step. It
/// is about where Bullet expected the object to come to at the velocity before contacts: how far it
/// comes from there is bounded by differences of velocities. Points that turn are off their chords
/// by an eighth of the square of the angle, relative to their distance from the axis.
bool btCcdTracker::staysInBox(const btCcdTracked& tracked, bool done) const
{
    const btRigidBody* body = btRigidBody::upcast(tracked.m_object);
    if (body == nullptr || tracked.m_way != nullptr || !tracked.m_turns)
    {
        return false;
    }
    const auto timeStep = btScalar(m_timeStep);
    const btVector3 turn = body->getAngularVelocity() * timeStep;
    const double angle = lengthOf(turn);
    const btTransform& from = body->getWorldTransform();
    const btTransform& to = done ? from : body->getInterpolationWorldTransform();
    double off = angle * angle / 8.0;
    double room = kTolerances * m_context.m_tolerance;
    if (!done)
    {
        btVector3 axis(0, 0, 0);  // times the sine of the angle from the one to the other
        for (int k = 0; k < 3; ++k)
        {
            axis += btScalar(0.5) * from.getBasis().getColumn(k).cross(to.getBasis().getColumn(k));
        }
        const double sine = lengthOf(axis);
        off += lengthOf(turn - axis) + 0.25 * sine * sine * sine;
        room += lengthOf(from.getOrigin() + body->getLinearVelocity() * timeStep - to.getOrigin());
        if (!(sine < kSmallTurn))
        {
            return false;
        }
    }
    room += off * tracked.outline().m_reach;
    const btBroadphaseProxy& proxy = *body->getBroadphaseHandle();
    const btVector3 size = proxy.m_aabbMax - proxy.m_aabbMin;
    if (!(angle < kSmallTurn && btScalar(room) < size[size.maxAxis()]))
    {
        return false;
    }
    btVector3 low;
    btVector3 high;
    tracked.m_collisionShape->getAabb(to, low, high);
    const btVector3 around = btVector3(1, 1, 1) * btScalar(room);
    return btCcdBox{proxy.m_aabbMin, proxy.m_aabbMax}.contains(low - around, high + around);
}

void btCcdTracker::addPresent(btCcdTracked& a, btCcdTracked& b)
{
    const bool pressed = a.m_pressed && b.m_pressed;
    if ((a.m_beyond + b.m_beyond > 0.0 || pressed) &&
        (moversCanCross() || !a.m_moves || !b.m_moves))
    {
        const auto [first, second] = std::minmax({&a, &b});
        m_present.push_back({first, second, -1.0, childOf(*first->m_object, *second->m_object)});
    }
}

/// What the broadphase has, and what strays may meet.
void btCcdTracker::takePresent()
{
    const auto trackedOf = [this](const btBroadphaseProxy& proxy)
    { return find(*static_cast<const btCollisionObject*>(proxy.m_clientObject)); };
    struct Found : btBroadphaseAabbCallback
    {
        std::vector<const btBroadphaseProxy*> m_proxies;
        bool process(const btBroadphaseProxy* proxy) override
        {
            m_proxies.push_back(proxy);
            return true;
        }
    } found;
    m_present.clear();
    btBroadphasePairArray& pairs = m_world.getPairCache()->getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); ++i)
    {
        btCcdTracked* a = trackedOf(*pairs[i].m_pProxy0);
        btCcdTracked* b = trackedOf(*pairs[i].m_pProxy1);
        if (a != nullptr && b != nullptr && !a->m_isStray && !b->m_isStray)
        {
            addPresent(*a, *b);
        }
    }
    m_strayBoxes.boxes().clear();
    for (const int index : m_strays)
    {
        btCcdTracked& stray = m_objects[std::size_t(index)];
        const btCcdBox place = placeOf(stray);
        m_strayBoxes.boxes().push_back(place);
        found.m_proxies.clear();
        m_world.getBroadphase()->aabbTest(place.m_low, place.m_high, found);
        for (const btBroadphaseProxy* proxy : found.m_proxies)
        {
            btCcdTracked* other = trackedOf(*proxy);
            if (other != nullptr && !other->m_isStray)
            {
                addPresent(stray, *other);
            }
        }
    }
    (void)m_strayBoxes.listAmongAll(kAnyNumber);
    for (const auto& [first, second] : m_strayBoxes.pairs())
    {
        addPresent(m_objects[std::size_t(m_strays[std::size_t(first)])],
                   m_objects[std::size_t(m_strays[std::size_t(second)])]);
    }
}

void btCcdTracker::findNeighbours(bool done)
{
    m_isInBoxes = listsMoversApart() && findStrays(done);
    if (m_isInBoxes)
    {
        takePresent();
        return;
    }
    forgetStrays();
    if (!m_isListed)
    {
        group();
        listWithRest();
    }
    m_isAlongUsed = listsMoversApart() && moversCanCross();
    if (!m_isAlongUsed)
    {
        return;
    }
    m_common = commonVelocity();
    if (!isAlongGood(m_common))
    {
        listMovers(m_common);
    }
}

bool btCcdTracker::staysInPlace(const btCcdTracked& tracked, double time, double remaining) const
{
    if ((!m_isAlongUsed && listsMoversApart()) || !tracked.m_isMover || !tracked.m_moves ||
        tracked.m_way != nullptr)
    {
        return false;
    }
    const btCcdCourse& course = tracked.m_course;
    const double way = lengthOf(tracked.m_shift) + tracked.m_turned + tracked.m_motion;
    if (!m_isAlongUsed)
    {
        return farthestAlongAxes(tracked.m_origin - tracked.m_listed.m_origin) + way <=
               tracked.m_listed.m_room;
    }
    const double along = lengthOf(tracked.m_shift - m_common * btScalar(time)) + tracked.m_turned +
                         remaining * (lengthOf(course.m_velocity - m_common) + course.m_turning);
    return farthestAlongAxes(tracked.m_origin - tracked.m_listed.m_origin) + way <=
               tracked.m_listed.m_room &&
           farthestAlongAxes(tracked.m_origin - tracked.m_along.m_origin - m_commonWay) + along <=
               tracked.m_along.m_room;
}
