#include "bullet_ccd/bullet/btCcdStepper.h"

#include "bullet_ccd/bullet/btCcdContext.h"
#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
constexpr double kNever = std::numeric_limits<double>::infinity();
/// Pairs that come together within this part of the tolerance count as simultaneous.
constexpr double kSimultaneous = 1.0 / 8.0;
/// Of what a pair can lose before it crosses, slow motion may use up this part unseen.
constexpr double kUnseen = 0.5;
/// What a shape may use up of the margin of the mesh that it meets.
constexpr double kPartnersShare = btCcdShareOfMargin;
/// Up to so many objects are quicker looked through than the broadphase is asked.
constexpr std::size_t kFew = 8;

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

bool meet(const btVector3& lowA,
          const btVector3& highA,
          const btVector3& lowB,
          const btVector3& highB)
{
    return TestAabbAgainstAabb2(lowA, highA, lowB, highB);
}
}  // namespace

/// What the broadphase finds in the box that an object sweeps.
class btCcdStepper::Candidates : public btBroadphaseAabbCallback
{
public:
    Candidates(btCcdStepper& stepper, int index) : m_stepper(stepper), m_index(index) {}

    bool process(const btBroadphaseProxy* proxy) override
    {
        const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
        Tracked* other = m_stepper.find(*object);
        // Fast objects sweep boxes of their own.
        if (other != nullptr && !other->m_fast)
        {
            m_stepper.addPair(m_index, int(other - m_stepper.m_objects.data()));
        }
        return true;
    }

private:
    btCcdStepper& m_stepper;
    int m_index;
};

btCcdStepper::btCcdStepper(btCollisionWorld& world)
    : m_world(world), m_context(btCcdContext::of(*world.getDispatcher()))
{
}

void btCcdStepper::setEnabled(const btCollisionObject* object, bool enabled)
{
    if (enabled)
    {
        m_disabled.erase(object);
    }
    else
    {
        m_disabled.insert(object);
    }
}

bool btCcdStepper::isEnabled(const btCollisionObject* object) const
{
    return m_disabled.empty() || m_disabled.count(object) == 0;
}

btCcdStepper::Tracked* btCcdStepper::find(const btCollisionObject& object)
{
    const auto index = std::size_t(object.getWorldArrayIndex());
    return index < m_objects.size() && m_objects[index].m_object == &object ? &m_objects[index]
                                                                            : nullptr;
}

bool btCcdStepper::Shape::isOf(const btCollisionShape& shape) const
{
    return m_shape == &shape && m_scaling == shape.getLocalScaling() &&
           m_margin == shape.getMargin() && m_revision == revisionOf(shape);
}

void btCcdStepper::lookAtShape(Tracked& tracked)
{
    const btCollisionShape& shape = *tracked.m_object->getCollisionShape();
    Shape& known = tracked.m_shape;
    if (known.isOf(shape))
    {
        return;
    }
    known = {&shape, shape.getLocalScaling(), shape.getMargin(), revisionOf(shape), false, {}};
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
}

void btCcdStepper::lookAt(Tracked& tracked, btCollisionObject& object)
{
    tracked.m_object = &object;
    tracked.m_fast = tracked.m_changed = tracked.m_pressed = tracked.m_stopped = false;
    tracked.m_motion = tracked.m_since = tracked.m_turned = 0.0;
    tracked.m_shift.setZero();
    tracked.m_course = {};
    lookAtShape(tracked);
    tracked.m_tracked = tracked.m_shape.m_covered && isEnabled(&object);
    m_counts.m_unsupported += tracked.m_shape.m_covered ? 0 : 1;
    m_smallestOwnMargin = std::min(m_smallestOwnMargin, tracked.m_shape.m_outline.m_ownMargin);
}

/// The whole look for a step like the last one, in which nothing could cross: objects and shapes
/// are the same, none is a link, nothing is pressed, and no two move enough. False if in doubt.
bool btCcdStepper::staysQuiet()
{
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    if (m_objects.size() != std::size_t(objects.size()))
    {
        return false;
    }
    double most = -kNever;
    double second = -kNever;
    for (int i = 0; i < objects.size(); ++i)
    {
        const Tracked& tracked = m_objects[std::size_t(i)];
        const btCollisionObject& object = *objects[i];
        const btRigidBody* body = btRigidBody::upcast(&object);
        if (tracked.m_object != &object || body == nullptr ||
            !tracked.m_shape.isOf(*object.getCollisionShape()))
        {
            return false;
        }
        if (!tracked.m_shape.m_covered || !isEnabled(&object))
        {
            continue;
        }
        const double motion = isMoved(object) ? m_timeStep * (norm(body->getLinearVelocity()) +
                                                              norm(body->getAngularVelocity()) *
                                                                  tracked.m_shape.m_outline.m_reach)
                                              : 0.0;
        const double beyond = beyondUnseen(tracked, motion);
        second = std::max(second, std::min(most, beyond));
        most = std::max(most, beyond);
    }
    const btDispatcher& dispatcher = *m_world.getDispatcher();
    Tracked* a = nullptr;
    Tracked* b = nullptr;
    for (int i = 0; i < dispatcher.getNumManifolds() && !(most + second > 0.0); ++i)
    {
        const auto* manifold = const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
        most = isPressed(*manifold, a, b) ? kNever : most;
    }
    return most + second <= 0.0;
}

bool btCcdStepper::begin(btScalar timeStep, Motion motion)
{
    m_motion = motion;
    m_timeStep = double(timeStep);
    m_time = 0.0;
    ++m_epoch;
    if (m_quiet && staysQuiet())
    {
        m_counts.m_queries = m_counts.m_overlaps = 0;
        for (const int index : m_fast)
        {
            m_objects[std::size_t(index)].m_fast = false;
        }
        m_fast.clear();
        return false;
    }
    m_counts = {};
    m_multiBodyCount = 0;
    m_pairs.clear();
    m_fast.clear();
    m_pressedPairs.clear();
    m_slowMotion = 0.0;
    m_smallestOwnMargin = kNever;

    btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    m_objects.resize(std::size_t(objects.size()));
    for (int i = 0; i < objects.size(); ++i)
    {
        lookAt(m_objects[std::size_t(i)], *objects[i]);
    }
    // What the two move most that move beyond what they may move unseen; the others less.
    double most = -kNever;
    double second = -kNever;
    for (Tracked& tracked : m_objects)
    {
        const double beyond = track(tracked);
        second = std::max(second, std::min(most, beyond));
        most = std::max(most, beyond);
    }
    markPressed();
    for (const int index : m_fast)
    {
        sweep(m_objects[std::size_t(index)]);
    }
    m_quiet = !(most + second > 0.0) && m_pressedPairs.empty();
    if (!m_quiet)
    {
        findPairs();
    }
    return !m_pairs.empty();
}

void btCcdStepper::findPairs()
{
    findSlow();
    for (const int index : m_fast)
    {
        addCandidates(index, false);
    }
    for (Pair& pair : m_pairs)
    {
        ask(pair);
    }
}

void btCcdStepper::findSlow()
{
    m_slow.clear();
    for (std::size_t i = 0; i < m_objects.size() && m_slow.size() <= kFew; ++i)
    {
        const Tracked& tracked = m_objects[i];
        if (tracked.m_tracked && !tracked.m_fast &&
            tracked.m_object->getBroadphaseHandle() != nullptr)
        {
            m_slow.push_back(int(i));
        }
    }
    m_fewSlow = m_slow.size() <= kFew;
}

/// What an object can lose, whatever it meets.
double btCcdStepper::reserveOf(const Tracked& tracked) const
{
    const btCcdShapeOutline& outline = tracked.m_shape.m_outline;
    // Half of what a mesh can lose is its partner's.
    return std::min(outline.m_reserve, kPartnersShare * m_smallestOwnMargin);
}

/// Returns how far the object moves beyond what it may move unseen. Two of which the sum is not
/// positive cannot cross.
double btCcdStepper::track(Tracked& tracked)
{
    if (!tracked.m_tracked)
    {
        return -kNever;
    }
    const double unseen = kUnseen * reserveOf(tracked);
    if (isMoved(*tracked.m_object))
    {
        take(tracked, courseOf(tracked));
        if (tracked.m_motion > unseen)
        {
            tracked.m_fast = true;
            m_fast.push_back(int(&tracked - m_objects.data()));
        }
        else
        {
            m_slowMotion = std::max(m_slowMotion, tracked.m_motion);
        }
    }
    return beyondUnseen(tracked, tracked.m_motion);
}

double btCcdStepper::beyondUnseen(const Tracked& tracked, double motion) const
{
    const btCcdShapeOutline& outline = tracked.m_shape.m_outline;
    // A convex shape may meet a mesh of stock Bullet, which has nothing to lose.
    const bool hasNothing = outline.m_hasMesh && outline.m_ownMargin == kNever;
    return hasNothing ? motion : motion - kUnseen * reserveOf(tracked);
}

btCcdStepper::Course btCcdStepper::courseOf(const Tracked& tracked)
{
    Course course;
    if (tracked.m_stopped)
    {
        return course;
    }
    const double reach = tracked.m_shape.m_outline.m_reach;
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
    const KnownMultiBody& owner = known(*collider->m_multiBody);
    const std::size_t link = 2 * std::size_t(collider->m_link + 1);
    if (owner.m_covered)
    {
        course.m_turning = owner.m_speeds[link] + owner.m_speeds[link + 1] * reach;
        if (!owner.m_body->hasFixedBase() && owner.m_speeds[0] > 0.0)
        {
            // All links have the velocity of the base, and that of their joints besides.
            course.m_velocity = owner.m_body->getBaseVel();
            course.m_turning -= owner.m_speeds[0];
        }
    }
    return course;
}

void btCcdStepper::take(Tracked& tracked, const Course& course)
{
    const double time = m_time - tracked.m_since;
    tracked.m_shift += tracked.m_course.m_velocity * btScalar(time);
    tracked.m_turned += tracked.m_course.m_turning * time;
    tracked.m_since = m_time;
    tracked.m_course = course;
    tracked.m_motion = remaining() * (norm(course.m_velocity) + course.m_turning);
}

btCcdStepper::KnownMultiBody& btCcdStepper::known(const btMultiBody& body)
{
    // Colliders of a body usually follow each other.
    for (std::size_t i = m_multiBodyCount; i-- > 0;)
    {
        if (m_multiBodies[i]->m_body == &body)
        {
            return *m_multiBodies[i];
        }
    }
    if (m_multiBodyCount == m_multiBodies.size())
    {
        m_multiBodies.push_back(std::make_unique<KnownMultiBody>());
    }
    KnownMultiBody& owner = *m_multiBodies[m_multiBodyCount++];
    owner.m_body = &body;
    owner.m_epoch = -1;
    owner.m_covered = btCcdIsCovered(body);
    if (owner.m_covered)
    {
        btCcdReadSpeeds(body, m_timeStep, owner.m_speeds);
    }
    return owner;
}

/// True if the solver has let the two sink in deeper than slow motion leaves room for.
bool btCcdStepper::isPressed(const btPersistentManifold& manifold, Tracked*& a, Tracked*& b)
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
    const btCcdShapeOutline& outlineA = a->m_shape.m_outline;
    const btCcdShapeOutline& outlineB = b->m_shape.m_outline;
    const double reserve = std::min(outlineA.m_reserve + outlineB.m_reserve,
                                    std::min(outlineA.m_ownMargin, outlineB.m_ownMargin));
    return -double(deepest) > (1.0 - kUnseen) * reserve;
}

void btCcdStepper::markPressed()
{
    btDispatcher& dispatcher = *m_world.getDispatcher();
    btPersistentManifold** manifolds = dispatcher.getInternalManifoldPointer();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    {
        Tracked* a = nullptr;
        Tracked* b = nullptr;
        if (!isPressed(*manifolds[i], a, b))
        {
            continue;
        }
        m_pressedPairs.push_back(std::minmax(int(a - m_objects.data()), int(b - m_objects.data())));
        for (Tracked* pressed : {a, b})
        {
            pressed->m_pressed = true;
            if (pressed->m_motion > 0.0 && !pressed->m_fast)
            {
                pressed->m_fast = true;
                m_fast.push_back(int(pressed - m_objects.data()));
            }
        }
    }
}

const btCcdObjectMotion* btCcdStepper::motionOf(const btCollisionObject& object)
{
    Tracked* tracked = find(object);
    if (tracked == nullptr || !tracked->m_tracked)
    {
        return nullptr;
    }
    if (tracked->m_epoch == m_epoch)
    {
        return &tracked->m_pose;
    }
    tracked->m_epoch = m_epoch;
    const double start = m_motion == Motion::Done ? -1.0 : 0.0;
    if (const auto* collider = btMultiBodyLinkCollider::upcast(&object))
    {
        KnownMultiBody& owner = known(*collider->m_multiBody);
        if (!owner.m_covered)
        {
            return nullptr;
        }
        if (owner.m_epoch != m_epoch)
        {
            owner.m_epoch = m_epoch;
            const double part = tracked->m_stopped ? 0.0 : remaining() / m_timeStep;
            // Fast spins are integrated in pieces or limited before, see btCcdControl.
            btCcdReadMotion(*collider->m_multiBody,
                            btScalar(m_timeStep),
                            owner.m_motion,
                            {.m_part = part, .m_done = start != 0.0, .m_inPieces = start == 0.0});
        }
        tracked->m_pose = btCcdLinkMotion(*collider, owner.m_motion);
    }
    else
    {
        const double part = tracked->m_stopped ? 0.0 : remaining() / m_timeStep;
        tracked->m_pose = {btCcdRigidMotion(object, m_timeStep, part, start)};
    }
    return &tracked->m_pose;
}

const btCcdMultiBodyMotion* btCcdStepper::multiBodyMotionOf(const btCollisionObject& object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    return collider != nullptr && motionOf(object) != nullptr
               ? &known(*collider->m_multiBody).m_motion
               : nullptr;
}

void btCcdStepper::sweep(Tracked& tracked)
{
    double reach = tracked.m_shape.m_outline.m_reach + m_context.m_tolerance + m_slowMotion;
    btVector3 from = tracked.m_object->getWorldTransform().getOrigin();
    btVector3 to = from;
    if (const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object))
    {
        // A link moves anywhere near. Its collider may not be where its joints are.
        const btMultiBody& body = *collider->m_multiBody;
        from = to = collider->m_link < 0
                        ? body.getBasePos()
                        : body.getLink(collider->m_link).m_cachedWorldTransform.getOrigin();
        reach += tracked.m_motion;
    }
    else
    {
        // Kinematic objects stand where the step began.
        const double time = tracked.m_object->isKinematicObject() ? m_timeStep
                            : m_motion == Motion::Done            ? -remaining()
                                                                  : remaining();
        to += tracked.m_course.m_velocity * btScalar(time);
    }
    if (!std::isfinite(tracked.m_motion) || !std::isfinite(from.length2()))
    {
        tracked.m_tracked = false;
        return;
    }
    const btVector3 around = btVector3(1, 1, 1) * btScalar(reach);
    tracked.m_low = tracked.m_high = from;
    tracked.m_low.setMin(to);
    tracked.m_high.setMax(to);
    tracked.m_low -= around;
    tracked.m_high += around;
}

void btCcdStepper::addCandidates(int index, bool onlyChanged)
{
    const Tracked& tracked = m_objects[std::size_t(index)];
    if (!tracked.m_tracked)
    {
        return;
    }
    for (const int other : m_fast)
    {
        const Tracked& b = m_objects[std::size_t(other)];
        // Of two objects that come this way, the pair comes once.
        const bool first = (tracked.m_fast && index < other) || (onlyChanged && !b.m_changed);
        if (other != index && first && b.m_tracked &&
            meet(tracked.m_low, tracked.m_high, b.m_low, b.m_high))
        {
            addPair(index, other);
        }
    }
    if (!tracked.m_fast)
    {
        return;
    }
    if (!m_fewSlow)
    {
        Candidates candidates(*this, index);
        m_world.getBroadphase()->aabbTest(tracked.m_low, tracked.m_high, candidates);
        return;
    }
    for (const int other : m_slow)
    {
        const Tracked& b = m_objects[std::size_t(other)];
        const btBroadphaseProxy& proxy = *b.m_object->getBroadphaseHandle();
        if (!b.m_fast && meet(tracked.m_low, tracked.m_high, proxy.m_aabbMin, proxy.m_aabbMax))
        {
            addPair(index, other);
        }
    }
}

void btCcdStepper::addPair(int a, int b)
{
    const auto [first, second] = std::minmax(a, b);
    const Tracked& trackedA = m_objects[std::size_t(first)];
    const Tracked& trackedB = m_objects[std::size_t(second)];
    if (wanted(trackedA, trackedB) && canCross(trackedA, trackedB))
    {
        // The order in which Bullet sees the pair: by the age of the objects.
        m_pairs.push_back({first, second, kNever, {}});
    }
}

bool btCcdStepper::wanted(const Tracked& a, const Tracked& b) const
{
    if (!a.m_tracked || !b.m_tracked || a.m_object == b.m_object ||
        (a.m_motion <= 0.0 && b.m_motion <= 0.0) || !b.m_object->hasContactResponse() ||
        !a.m_object->hasContactResponse() || !a.m_object->checkCollideWith(b.m_object))
    {
        return false;
    }
    btDispatcher& dispatcher = *const_cast<btCollisionWorld&>(m_world).getDispatcher();
    const btOverlappingPairCache& cache = *const_cast<btCollisionWorld&>(m_world).getPairCache();
    return cache.needsBroadphaseCollision(a.m_object->getBroadphaseHandle(),
                                          b.m_object->getBroadphaseHandle()) &&
           dispatcher.needsCollision(a.m_object, b.m_object) &&
           dispatcher.needsResponse(a.m_object, b.m_object);
}

/// Bound of what any point of one object moves in this step relative to the other.
double btCcdStepper::wayApart(const Tracked& a, const Tracked& b) const
{
    const double sinceA = m_time - a.m_since;
    const double sinceB = m_time - b.m_since;
    const Course& courseA = a.m_course;
    const Course& courseB = b.m_course;
    const btVector3 past = (a.m_shift + courseA.m_velocity * btScalar(sinceA)) -
                           (b.m_shift + courseB.m_velocity * btScalar(sinceB));
    const double turned =
        a.m_turned + courseA.m_turning * sinceA + b.m_turned + courseB.m_turning * sinceB;
    return norm(past) + turned +
           remaining() * (norm(courseA.m_velocity - courseB.m_velocity) + courseA.m_turning +
                          courseB.m_turning);
}

/// False if the two move too little to cross each other, as begin() counts it.
bool btCcdStepper::canCross(const Tracked& a, const Tracked& b)
{
    if (a.m_pressed && b.m_pressed &&
        std::find(m_pressedPairs.begin(),
                  m_pressedPairs.end(),
                  std::pair(int(&a - m_objects.data()), int(&b - m_objects.data()))) !=
            m_pressedPairs.end())
    {
        return true;
    }
    const btCcdShapeOutline& outlineA = a.m_shape.m_outline;
    const btCcdShapeOutline& outlineB = b.m_shape.m_outline;
    const bool stock = outlineA.m_ownMargin == kNever && outlineB.m_ownMargin == kNever;
    if (stock && !(outlineA.m_hasMesh && outlineB.m_hasMesh))
    {
        return wayApart(a, b) > kUnseen * (outlineA.m_depth + outlineB.m_depth);
    }
    const btCcdShapeModel* modelA = m_context.model(a.m_object->getCollisionShape());
    const btCcdShapeModel* modelB = m_context.model(b.m_object->getCollisionShape());
    return modelA != nullptr && modelB != nullptr &&
           wayApart(a, b) > kUnseen * btCcdReserve(*modelA, *modelB);
}

void btCcdStepper::ask(Pair& pair)
{
    btCollisionObject* a = m_objects[std::size_t(pair.m_a)].m_object;
    btCollisionObject* b = m_objects[std::size_t(pair.m_b)].m_object;
    btDispatcher& dispatcher = *m_world.getDispatcher();
    btBroadphasePair* known =
        m_world.getPairCache()->findPair(a->getBroadphaseHandle(), b->getBroadphaseHandle());
    btCollisionAlgorithm* algorithm = known != nullptr ? known->m_algorithm : nullptr;
    const bool made = algorithm == nullptr;
    if (made)
    {
        const btCollisionObjectWrapper wrapA(
            nullptr, a->getCollisionShape(), a, a->getWorldTransform(), -1, -1);
        const btCollisionObjectWrapper wrapB(
            nullptr, b->getCollisionShape(), b, b->getWorldTransform(), -1, -1);
        algorithm = dispatcher.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    }
    btDispatcherInfo info = m_world.getDispatchInfo();
    info.m_timeStep = btScalar(remaining());
    btCcdImpactResult result;
    m_context.m_motions = this;
    const double fraction = double(algorithm->calculateTimeOfImpact(a, b, info, &result));
    m_context.m_motions = nullptr;
    if (made)
    {
        algorithm->~btCollisionAlgorithm();
        dispatcher.freeCollisionAlgorithm(algorithm);
    }
    ++m_counts.m_queries;
    m_counts.m_overlaps += result.m_toi.m_status == bullet_ccd::ToiStatus::Overlapping ? 1 : 0;
    pair.m_toi = result.m_toi;
    pair.m_time = fraction < 1.0 ? m_time + fraction * remaining() : kNever;
}

btCcdStepper::Event btCcdStepper::next()
{
    Event event;
    double earliest = kNever;
    for (const Pair& pair : m_pairs)
    {
        earliest = std::min(earliest, pair.m_time);
    }
    if (earliest == kNever)
    {
        return event;
    }
    event.m_found = true;
    event.m_time = std::clamp(btCcdRoundDown(earliest), btScalar(m_time), btScalar(m_timeStep));
    for (Pair& pair : m_pairs)
    {
        const double speed = (m_objects[std::size_t(pair.m_a)].m_motion +
                              m_objects[std::size_t(pair.m_b)].m_motion) /
                             m_timeStep;
        if (pair.m_time == earliest ||
            (pair.m_time - earliest) * speed <= kSimultaneous * m_context.m_tolerance)
        {
            event.m_gaveUp =
                event.m_gaveUp || pair.m_toi.m_status == bullet_ccd::ToiStatus::IterationLimit;
            pair.m_met = true;
            event.m_impacts.push_back(impactOf(pair, event.m_time));
            if (pair.m_time == earliest)
            {
                std::swap(event.m_impacts.front(), event.m_impacts.back());
            }
        }
    }
    return event;
}

btCcdImpact btCcdStepper::impactOf(const Pair& pair, btScalar time) const
{
    const auto linkOf = [](const btCollisionObject* object)
    {
        const auto* collider = btMultiBodyLinkCollider::upcast(object);
        return collider != nullptr ? collider->m_link : btCcdImpact::kNoLink;
    };
    btCollisionObject* a = m_objects[std::size_t(pair.m_a)].m_object;
    btCollisionObject* b = m_objects[std::size_t(pair.m_b)].m_object;
    return {a,
            b,
            linkOf(a),
            linkOf(b),
            time,
            btCcdToBullet(pair.m_toi.m_pointA),
            btCcdToBullet(pair.m_toi.m_pointB),
            btCcdToBullet(pair.m_toi.m_normal)};
}

void btCcdStepper::advance(btScalar time)
{
    m_time = double(time);
    ++m_epoch;
}

void btCcdStepper::changed(const btCollisionObject& object)
{
    const auto mark = [this](const btCollisionObject* part)
    {
        Tracked* tracked = part != nullptr ? find(*part) : nullptr;
        if (tracked != nullptr)
        {
            tracked->m_changed = true;
            tracked->m_stopped = tracked->m_stopped || m_motion == Motion::Done;
        }
    };
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    if (collider == nullptr)
    {
        // What is fixed goes on as before: its other pairs keep their answers.
        if (!object.isStaticObject() || object.isKinematicObject())
        {
            mark(&object);
        }
        return;
    }
    const btMultiBody& body = *collider->m_multiBody;
    mark(body.getBaseCollider());
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        mark(body.getLink(i).m_collider);
    }
}

/// False if the object moves on as it did.
bool btCcdStepper::takeNewCourse(Tracked& tracked)
{
    const Course course = courseOf(tracked);
    if (btMultiBodyLinkCollider::upcast(tracked.m_object) == nullptr &&
        course.m_velocity == tracked.m_course.m_velocity &&
        course.m_spin == tracked.m_course.m_spin)
    {
        return false;
    }
    take(tracked, course);
    const double way = norm(tracked.m_shift) + tracked.m_turned + tracked.m_motion;
    if (!tracked.m_fast && (way > kUnseen * reserveOf(tracked) || way > m_slowMotion ||
                            (tracked.m_pressed && tracked.m_motion > 0.0)))
    {
        // From now on it is not where the broadphase saw it.
        tracked.m_fast = true;
        m_fast.push_back(int(&tracked - m_objects.data()));
    }
    return true;
}

void btCcdStepper::refresh()
{
    ++m_epoch;
    m_multiBodyCount = 0;
    std::vector<int> changed;
    for (Tracked& tracked : m_objects)
    {
        tracked.m_changed = tracked.m_changed && tracked.m_tracked && takeNewCourse(tracked);
        if (tracked.m_changed)
        {
            changed.push_back(int(&tracked - m_objects.data()));
            sweep(tracked);
        }
    }
    const auto of = [this](int index) -> const Tracked& { return m_objects[std::size_t(index)]; };
    std::erase_if(m_pairs,
                  [&](const Pair& pair)
                  {
                      const Tracked& a = of(pair.m_a);
                      const Tracked& b = of(pair.m_b);
                      return a.m_changed || b.m_changed || (pair.m_met && !wanted(a, b));
                  });
    const std::size_t before = m_pairs.size();
    for (const int index : changed)
    {
        addCandidates(index, true);
    }
    for (std::size_t i = 0; i < m_pairs.size(); ++i)
    {
        if (i >= before || m_pairs[i].m_met)
        {
            m_pairs[i].m_met = false;
            ask(m_pairs[i]);
        }
    }
    for (const int index : changed)
    {
        m_objects[std::size_t(index)].m_changed = false;
    }
}

void btCcdStepper::end()
{
    m_context.m_shapes.endRound();
}

bool btCcdStepper::sweptBox(const btCollisionObject& object, btVector3& low, btVector3& high)
{
    const Tracked* tracked = find(object);
    if (tracked == nullptr || !tracked->m_tracked || !tracked->m_fast)
    {
        return false;
    }
    low = tracked->m_low;
    high = tracked->m_high;
    return true;
}
