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
constexpr double kPartnersShare = 0.5 * btCcdReserveOfMargin;

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

void btCcdStepper::lookAtShape(Tracked& tracked)
{
    const btCollisionShape& shape = *tracked.m_object->getCollisionShape();
    Shape& known = tracked.m_shape;
    const btVector3& scaling = shape.getLocalScaling();
    const int revision = revisionOf(shape);
    if (known.m_shape == &shape && known.m_scaling == scaling &&
        known.m_margin == shape.getMargin() && known.m_revision == revision)
    {
        return;
    }
    const btCcdShapeModel* model = m_context.model(&shape);
    known = {&shape, scaling, shape.getMargin(), revision, model != nullptr, 0.0, 0.0, kNever};
    if (model != nullptr)
    {
        known.m_reach = model->m_reach;
        known.m_reserve = model->m_reserve;
        known.m_ownMargin = model->m_ownMargin;
    }
}

bool btCcdStepper::begin(btScalar timeStep, Motion motion)
{
    m_counts = {};
    m_motion = motion;
    m_timeStep = double(timeStep);
    m_time = 0.0;
    ++m_epoch;
    m_multiBodyCount = 0;
    m_pairs.clear();
    m_fast.clear();
    m_slowMotion = 0.0;
    m_smallestOwnMargin = kNever;

    btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    m_objects.resize(std::size_t(objects.size()));
    for (int i = 0; i < objects.size(); ++i)
    {
        Tracked& tracked = m_objects[std::size_t(i)];
        tracked.m_object = objects[i];
        tracked.m_motion = 0.0;
        tracked.m_fast = tracked.m_changed = tracked.m_stopped = false;
        lookAtShape(tracked);
        tracked.m_tracked = tracked.m_shape.m_covered && isEnabled(objects[i]);
        m_counts.m_unsupported += tracked.m_shape.m_covered ? 0 : 1;
        m_smallestOwnMargin = std::min(m_smallestOwnMargin, tracked.m_shape.m_ownMargin);
    }
    for (Tracked& tracked : m_objects)
    {
        track(tracked);
    }
    markPressed();
    for (const int index : m_fast)
    {
        sweep(m_objects[std::size_t(index)]);
    }
    for (const int index : m_fast)
    {
        addCandidates(index, false);
    }
    for (Pair& pair : m_pairs)
    {
        ask(pair);
    }
    return !m_pairs.empty();
}

void btCcdStepper::track(Tracked& tracked)
{
    if (!tracked.m_tracked || !isMoved(*tracked.m_object))
    {
        return;
    }
    tracked.m_motion = motionBound(tracked);
    // Half of what a mesh can lose is its partner's.
    const double reserve =
        std::min(tracked.m_shape.m_reserve, kPartnersShare * m_smallestOwnMargin);
    if (tracked.m_motion > kUnseen * reserve)
    {
        tracked.m_fast = true;
        m_fast.push_back(int(&tracked - m_objects.data()));
    }
    else
    {
        m_slowMotion = std::max(m_slowMotion, tracked.m_motion);
    }
}

double btCcdStepper::motionBound(const Tracked& tracked)
{
    const double reach = tracked.m_shape.m_reach;
    if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
    {
        return remaining() *
               (norm(body->getLinearVelocity()) + norm(body->getAngularVelocity()) * reach);
    }
    const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
    if (collider == nullptr)
    {
        return 0.0;
    }
    const KnownMultiBody& owner = known(*collider->m_multiBody);
    const std::size_t link = 2 * std::size_t(collider->m_link + 1);
    return owner.m_covered ? remaining() * (owner.m_speeds[link] + owner.m_speeds[link + 1] * reach)
                           : 0.0;
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

/// Pairs that the solver has let sink in deeper than slow motion leaves room for.
void btCcdStepper::markPressed()
{
    const btDispatcher& dispatcher = *m_world.getDispatcher();
    btPersistentManifold** manifolds =
        const_cast<btDispatcher&>(dispatcher).getInternalManifoldPointer();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
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
        Tracked* a = find(*manifold.getBody0());
        Tracked* b = find(*manifold.getBody1());
        if (a == nullptr || b == nullptr)
        {
            continue;
        }
        const double reserve = std::min(a->m_shape.m_reserve + b->m_shape.m_reserve,
                                        std::min(a->m_shape.m_ownMargin, b->m_shape.m_ownMargin));
        if (-double(deepest) <= (1.0 - kUnseen) * reserve)
        {
            continue;
        }
        for (Tracked* pressed : {a, b})
        {
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
    const btCcdObjectMotion* motion = motionOf(*tracked.m_object);
    if (motion == nullptr || !motion->isFinite())
    {
        tracked.m_tracked = false;
        return;
    }
    const Eigen::Vector3d from = btCcdShapePoseAt(*motion, 0.0).translation();
    const Eigen::Vector3d to = btCcdShapePoseAt(*motion, 1.0).translation();
    // The origin of a free body moves on a straight line, that of a link anywhere near.
    const bool isLink = std::holds_alternative<bullet_ccd::LinkMotion>(motion->m_motion);
    const double reach = tracked.m_shape.m_reach + m_context.m_tolerance + m_slowMotion +
                         (isLink ? tracked.m_motion : 0.0);
    tracked.m_low = btCcdToBullet(Eigen::Vector3d(from.cwiseMin(to).array() - reach));
    tracked.m_high = btCcdToBullet(Eigen::Vector3d(from.cwiseMax(to).array() + reach));
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
        const bool first = index < other || (onlyChanged && !b.m_changed);
        if (other != index && first && b.m_tracked &&
            meet(tracked.m_low, tracked.m_high, b.m_low, b.m_high))
        {
            addPair(index, other);
        }
    }
    Candidates candidates(*this, index);
    m_world.getBroadphase()->aabbTest(tracked.m_low, tracked.m_high, candidates);
}

void btCcdStepper::addPair(int a, int b)
{
    const Tracked& trackedA = m_objects[std::size_t(a)];
    const Tracked& trackedB = m_objects[std::size_t(b)];
    if (wanted(trackedA, trackedB) && canCross(trackedA, trackedB))
    {
        // The order in which Bullet sees the pair: by the age of the objects.
        m_pairs.push_back({std::min(a, b), std::max(a, b), kNever, {}});
    }
}

bool btCcdStepper::wanted(const Tracked& a, const Tracked& b) const
{
    if (!a.m_tracked || !b.m_tracked || a.m_object == b.m_object ||
        (a.m_motion <= 0.0 && b.m_motion <= 0.0) || !b.m_object->hasContactResponse() ||
        !a.m_object->hasContactResponse())
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

/// False if the two together move too little to cross each other, as begin() counts it.
bool btCcdStepper::canCross(const Tracked& a, const Tracked& b)
{
    const btCcdShapeModel* modelA = m_context.model(a.m_object->getCollisionShape());
    const btCcdShapeModel* modelB = m_context.model(b.m_object->getCollisionShape());
    if (modelA == nullptr || modelB == nullptr)
    {
        return false;
    }
    const bool sunken = a.m_fast && b.m_fast;  // perhaps only because they are
    return sunken || a.m_motion + b.m_motion > kUnseen * btCcdReserve(*modelA, *modelB);
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
    for (const Pair& pair : m_pairs)
    {
        const double speed = (m_objects[std::size_t(pair.m_a)].m_motion +
                              m_objects[std::size_t(pair.m_b)].m_motion) /
                             m_timeStep;
        if (pair.m_time == earliest ||
            (pair.m_time - earliest) * speed <= kSimultaneous * m_context.m_tolerance)
        {
            event.m_gaveUp =
                event.m_gaveUp || pair.m_toi.m_status == bullet_ccd::ToiStatus::IterationLimit;
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

void btCcdStepper::refresh()
{
    ++m_epoch;
    const auto isChanged = [this](int index) { return m_objects[std::size_t(index)].m_changed; };
    std::erase_if(m_pairs,
                  [&](const Pair& pair) { return isChanged(pair.m_a) || isChanged(pair.m_b); });
    m_multiBodyCount = 0;

    std::vector<int> changed;
    for (Tracked& tracked : m_objects)
    {
        if (tracked.m_changed && tracked.m_tracked)
        {
            // From now on it is not where the broadphase saw it, so it counts as fast in any case.
            tracked.m_fast = true;
            tracked.m_motion = tracked.m_stopped ? 0.0 : motionBound(tracked);
            changed.push_back(int(&tracked - m_objects.data()));
        }
    }
    std::erase_if(m_fast, isChanged);
    m_fast.insert(m_fast.end(), changed.begin(), changed.end());
    for (const int index : changed)
    {
        sweep(m_objects[std::size_t(index)]);
    }
    const std::size_t before = m_pairs.size();
    for (const int index : changed)
    {
        addCandidates(index, true);
    }
    for (std::size_t i = before; i < m_pairs.size(); ++i)
    {
        ask(m_pairs[i]);
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
