#include "bullet_ccd/bullet/step/btCcdStepper.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdPairRules.h"
#include "bullet_ccd/bullet/step/btCcdProgress.h"
#include "bullet_ccd/bullet/step/btCcdTracker.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <optional>
#include <span>

namespace
{
constexpr double kNever = std::numeric_limits<double>::infinity();
/// Pairs that come together within this part of the tolerance count as simultaneous.
constexpr double kSimultaneous = 1.0 / 8.0;
constexpr double kUnseen = btCcdTracker::kUnseen;
/// Up to so many objects are quicker looked through than the broadphase is asked.
constexpr std::size_t kFew = 8;
/// So many queries are asked on several threads, before it is seen whether one of them makes the
/// others needless.
constexpr std::size_t kAtOnce = 16;

/// By the multibody that it belongs to now.
bool isBarredFromParent(const btMultiBodyLinkCollider& child)
{
    return child.m_link >= 0 && child.m_link < child.m_multiBody->getNumLinks() &&
           (child.m_multiBody->getLink(child.m_link).m_flags &
            BT_MULTIBODYLINKFLAGS_DISABLE_PARENT_COLLISION) != 0;
}

double norm(const btVector3& v)
{
    return double(v.length());
}

bullet_ccd::RigidMotion withoutTurn(bullet_ccd::RigidMotion motion)
{
    motion.w_W.setZero();
    return motion;
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
        const btCcdTracked* other = m_stepper.m_tracker->find(*object);
        if (other != nullptr && !m_stepper.sweepsBox(*other) &&
            (other->m_fast || m_stepper.at(m_index).m_fast))
        {
            m_stepper.addPair(m_index, m_stepper.indexOf(*other));
        }
        return true;
    }

private:
    btCcdStepper& m_stepper;
    int m_index;
};

btCcdStepper::btCcdStepper(btCollisionWorld& world, btCcdProgress& progress)
    : m_world(world),
      m_context(btCcdContext::of(*world.getDispatcher())),
      m_progress(progress),
      m_tracker(std::make_unique<btCcdTracker>(world))
{
}

btCcdStepper::~btCcdStepper() = default;

/// The object, or all colliders of the multibody that it belongs to.
template <typename Visit>
void btCcdStepper::forParts(const btCollisionObject& object, const Visit& visit)
{
    const auto see = [&](const btCollisionObject* part)
    {
        if (btCcdTracked* tracked = part != nullptr ? m_tracker->find(*part) : nullptr)
        {
            visit(*tracked);
        }
    };
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    if (collider == nullptr)
    {
        see(&object);
        return;
    }
    const btMultiBody& body = *collider->m_multiBody;
    see(body.getBaseCollider());
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        see(body.getLink(i).m_collider);
    }
}

void btCcdStepper::forgetShapes()
{
    m_tracker->forgetShapes();
}

void btCcdStepper::prepare()
{
    m_tracker->prepare();
    m_poses.resize(m_tracker->objects().size());
}

inline btCcdTracked& btCcdStepper::at(int index)
{
    return m_tracker->objects()[std::size_t(index)];
}

inline const btCcdTracked& btCcdStepper::at(int index) const
{
    return std::as_const(*m_tracker).objects()[std::size_t(index)];
}

inline int btCcdStepper::indexOf(const btCcdTracked& tracked) const
{
    return int(&tracked - m_tracker->objects().data());
}

void btCcdStepper::newStep()
{
    if (!m_starts.empty())
    {
        m_starts.clear();
    }
    m_tracker->newStep();
}

void btCcdStepper::endStep()
{
    m_tracker->endStep();
}

void btCcdStepper::mayBePushed(const btCollisionObject& object)
{
    m_tracker->mayBePushed(object);
}

void btCcdStepper::teleported(const btCollisionObject& object)
{
    m_tracker->teleported(object);
}

bool btCcdStepper::begin(btScalar timeStep, Motion motion, bool kinematicStands)
{
    m_motion = motion;
    m_timeStep = double(timeStep);
    m_time = 0.0;
    m_counts = {};
    m_pairs.clear();
    m_fast.clear();
    m_changed.clear();
    m_isNearListed = false;
    if (m_tracker->look(m_timeStep, kinematicStands))
    {
        m_tracker->findNeighbours(motion == Motion::Done);
        if (m_tracker->isInBoxes())
        {
            findPairs(m_tracker->present());
            return !m_pairs.empty();
        }
        if (m_tracker->moversCanCross())
        {
            findPairs(m_tracker->movers());
        }
        findPairs(m_tracker->others());
    }
    return !m_pairs.empty();
}

/// Bound of what any point of one object moves in the rest of the step relative to the other,
inline double btCcdStepper::wayToCome(const btCcdTracked& a, const btCcdTracked& b) const
{
    return remaining() * (norm(a.m_course.m_velocity - b.m_course.m_velocity) +
                          a.m_course.m_turning + b.m_course.m_turning);
}

/// and in all of it.
inline double btCcdStepper::wayApart(const btCcdTracked& a, const btCcdTracked& b) const
{
    const btCcdCourse& courseA = a.m_course;
    const btCcdCourse& courseB = b.m_course;
    const double toCome = wayToCome(a, b);
    if (m_time == 0.0)
    {
        return toCome;
    }
    const double sinceA = m_time - a.m_since;
    const double sinceB = m_time - b.m_since;
    const btVector3 past = (a.m_shift + courseA.m_velocity * btScalar(sinceA)) -
                           (b.m_shift + courseB.m_velocity * btScalar(sinceB));
    const double turned =
        a.m_turned + courseA.m_turning * sinceA + b.m_turned + courseB.m_turning * sinceB;
    return norm(past) + turned + toCome;
}

/// False if the two move too little to cross each other, as begin() counts it, and Bullet's
/// contacts have them where they are.
inline bool btCcdStepper::canCross(const btCcdTracked& a, const btCcdTracked& b, double mayLose)
{
    if (a.m_pressed && b.m_pressed)
    {
        mayLose = std::min(mayLose, m_tracker->leftOf(indexOf(a), indexOf(b)));
    }
    const auto isAhead = [mayLose](const btCcdTracked& tracked)
    { return tracked.m_way != nullptr && tracked.m_way->m_ahead > mayLose; };
    return mayLose < kNever && (wayApart(a, b) > mayLose || isAhead(a) || isAhead(b));
}

/// In the order of what it costs to see that a pair cannot meet.
void btCcdStepper::findPairs(std::vector<btCcdNeighbourPair>& neighbours)
{
    for (btCcdNeighbourPair& pair : neighbours)
    {
        const btCcdTracked& a = *pair.m_a;
        const btCcdTracked& b = *pair.m_b;
        if (!(a.m_beyond + b.m_beyond > 0.0) && !(a.m_pressed && b.m_pressed))
        {
            continue;
        }
        // What Bullet asks of links first, without the detours.
        if (pair.m_child != nullptr && isBarredFromParent(*pair.m_child))
        {
            continue;
        }
        // Joined objects mostly do not collide.
        if (!a.m_tracked || !b.m_tracked || btCcdTracker::areBoxesApart(a, b) ||
            !a.m_object->checkCollideWith(b.m_object))
        {
            continue;
        }
        if (pair.m_mayLose < 0.0)
        {
            pair.m_mayLose = btCcdMayLose(m_context, a, b);
        }
        if (!canCross(a, b, pair.m_mayLose) || !wanted(a, b))
        {
            continue;
        }
        // Once one pair may meet, it is early enough to look at the others when it is their turn.
        const bool isLooked = m_pairs.empty();
        if (const double time = isLooked ? earliestTime(a, b) : boxesMeet(a, b); time < kNever)
        {
            push(indexOf(a), indexOf(b), time).m_isLooked = isLooked;
        }
    }
}

inline btCcdStepper::Pair& btCcdStepper::push(int a, int b, double time)
{
    const double speed = (at(a).m_motion + at(b).m_motion) / m_timeStep;
    const double tolerance = m_context.toleranceOf(*at(a).m_object, *at(b).m_object);
    return m_pairs.emplace_back(Pair{.m_a = a,
                                     .m_b = b,
                                     .m_time = time,
                                     .m_toi = {},
                                     .m_window = kSimultaneous * tolerance / speed});
}

/// A time of the step before which the two certainly do not meet; infinite if they do not meet.
double btCcdStepper::earliestTime(const btCcdTracked& a, const btCcdTracked& b) const
{
    const double boxes = boxesMeet(a, b);
    return boxes < kNever ? std::max(boxes, approach(a, b)) : kNever;
}

/// False if Bullet does not have them where they are, or will be.
bool btCcdStepper::isKnown(const btCcdTracked& a, const btCcdTracked& b) const
{
    // In the middle of a step, others are not where Bullet has them.
    const auto isInPlace = [this](const btCcdTracked& tracked)
    {
        return m_time == 0.0 || (tracked.m_way == nullptr &&
                                 btMultiBodyLinkCollider::upcast(tracked.m_object) == nullptr);
    };
    // Queries have what does not turn as it was turned when the step began.
    const bool isTurned = m_motion == Motion::Done && !(a.m_turns && b.m_turns);
    return isInPlace(a) && isInPlace(b) && !isTurned;
}

/// The same by boxes alone,
double btCcdStepper::boxesMeet(const btCcdTracked& a, const btCcdTracked& b) const
{
    if (!isKnown(a, b))
    {
        return m_time;
    }
    const bool done = m_motion == Motion::Done;
    const double way = std::min(a.m_motion + b.m_motion, wayToCome(a, b));
    const double free = btCcdFreeWay(m_context, a, b, way, done);
    if (free > way)
    {
        return kNever;
    }
    // Of a motion that is done, they are known where it ends.
    return done || !(free > 0.0) ? m_time : m_time + free / way * remaining();
}

/// and by a look along one direction.
double btCcdStepper::approach(const btCcdTracked& a, const btCcdTracked& b) const
{
    if (!isKnown(a, b) || !btCcdApproach::isOf(a, b))
    {
        return m_time;
    }
    const btBroadphasePair* known = m_world.getPairCache()->findPair(
        a.m_object->getBroadphaseHandle(), b.m_object->getBroadphaseHandle());
    const bool done = m_motion == Motion::Done;
    return m_time + btCcdApproach(m_context, a, b, known, remaining(), done).freeTime();
}

void btCcdStepper::readyMotions()
{
    ++m_epoch;
    m_multiBodyCount = 0;
    m_poses.resize(m_tracker->objects().size());
}

void btCcdStepper::getReady()
{
    BT_PROFILE("btCcdStepper::getReady");
    readyMotions();
    m_tracker->noteChanges();
    findFast();
    for (const int index : m_fast)
    {
        sweep(at(index));
    }
    for (const int index : m_tracker->strays())
    {
        sweep(at(index));
    }
    if (!m_tracker->isInBoxes())
    {
        findSlow();
    }
}

double btCcdStepper::tolerance() const
{
    return m_context.m_tolerance;
}

std::int64_t btCcdStepper::unsupported() const
{
    return m_tracker->unsupported();
}

bool btCcdStepper::covers(const btCollisionObject& object) const
{
    const btCcdTracked* tracked = std::as_const(*m_tracker).find(object);
    return tracked != nullptr && tracked->m_usable;
}

bool btCcdStepper::seesStockClamping() const
{
    return m_tracker->seesStockClamping();
}

void btCcdStepper::findFast()
{
    m_slowMotion = 0.0;
    m_swept.clear();
    std::vector<btCcdTracked>& objects = m_tracker->objects();
    for (btCcdTracked& tracked : objects)
    {
        tracked.m_sweptAt = -1;
        if (const btRigidBody* body = btRigidBody::upcast(tracked.m_object))
        {
            const btVector3& spin =
                tracked.m_way != nullptr ? tracked.m_way->m_spin : body->getAngularVelocity();
            tracked.m_course.m_spin = tracked.m_motion > 0.0 ? spin : btVector3(0, 0, 0);
        }
        tracked.m_fast = tracked.m_tracked && (tracked.farthest() > tracked.m_slow ||
                                               (tracked.m_pressed && tracked.m_motion > 0.0));
        if (tracked.m_fast)
        {
            m_fast.push_back(indexOf(tracked));
        }
        else if (tracked.m_tracked)
        {
            m_slowMotion = std::max(m_slowMotion, tracked.m_motion);
        }
    }
}

void btCcdStepper::findSlow()
{
    m_slow.clear();
    const std::vector<btCcdTracked>& objects = m_tracker->objects();
    for (std::size_t i = 0; i < objects.size() && m_slow.size() <= kFew; ++i)
    {
        const btCcdTracked& tracked = objects[i];
        if (tracked.m_tracked && !tracked.m_fast &&
            tracked.m_object->getBroadphaseHandle() != nullptr)
        {
            m_slow.push_back(int(i));
        }
    }
    m_fewSlow = m_slow.size() <= kFew;
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
    return owner;
}

const btCcdObjectMotion* btCcdStepper::motionOf(const btCollisionObject& object)
{
    const btCcdTracked* tracked = m_tracker->find(object);
    if (tracked == nullptr || !tracked->m_tracked)
    {
        return nullptr;
    }
    Pose& pose = m_poses[std::size_t(indexOf(*tracked))];
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    if (collider != nullptr && !known(*collider->m_multiBody).m_covered)
    {
        return nullptr;
    }
    if (pose.m_epoch != m_epoch)
    {
        pose.m_epoch = m_epoch;
        m_progress.bring(object);
        readPose(*tracked, pose.m_motion);
    }
    return &pose.m_motion;
}

void btCcdStepper::readPose(const btCcdTracked& tracked, btCcdObjectMotion& pose)
{
    const double start = m_motion == Motion::Done ? -1.0 : 0.0;
    const double part = tracked.m_stopped ? 0.0 : remaining() / m_timeStep;
    const auto* collider = btMultiBodyLinkCollider::upcast(tracked.m_object);
    if (tracked.m_jumped)
    {
        pose = {bullet_ccd::restAt(btCcdToEigen(tracked.m_object->getWorldTransform()))};
        return;
    }
    const auto begun = m_starts.find(tracked.m_object);
    const bool isPushed = begun != m_starts.end() && m_motion == Motion::Done && !tracked.m_stopped;
    if (isPushed || tracked.m_way != nullptr)
    {
        const btTransform& from = isPushed ? begun->second : tracked.m_way->m_start;
        const btTransform& to = isPushed                  ? tracked.m_object->getWorldTransform()
                                : tracked.m_motion == 0.0 ? from
                                                          : tracked.m_way->m_end;
        bullet_ccd::RigidMotion motion =
            bullet_ccd::motionBetween(btCcdToEigen(from), btCcdToEigen(to));
        motion.X_W0 = motion.at(1.0 - part).X_W;
        motion.v_W *= part;
        motion.w_W *= part;
        pose = {tracked.m_turns ? motion : withoutTurn(motion)};
        return;
    }
    if (collider == nullptr)
    {
        m_context.checkPose(*tracked.m_object);
        const bullet_ccd::RigidMotion motion =
            btCcdRigidMotion(*tracked.m_object, m_timeStep, part, start);
        pose = {tracked.m_turns ? motion : withoutTurn(motion)};
        return;
    }
    KnownMultiBody& owner = known(*collider->m_multiBody);
    if (owner.m_epoch != m_epoch)
    {
        owner.m_epoch = m_epoch;
        // Fast spins are integrated in pieces or limited before, see btCcdControl.
        btCcdReadMotion(*collider->m_multiBody,
                        btScalar(m_timeStep),
                        owner.m_motion,
                        {.m_part = part, .m_done = start != 0.0, .m_inPieces = start == 0.0});
    }
    pose = btCcdLinkMotion(*collider, owner.m_motion);
    pose.m_way = tracked.m_motion;
}

const btCcdMultiBodyMotion* btCcdStepper::multiBodyMotionOf(const btCollisionObject& object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    return collider != nullptr && motionOf(object) != nullptr
               ? &known(*collider->m_multiBody).m_motion
               : nullptr;
}

void btCcdStepper::sweep(btCcdTracked& tracked)
{
    double reach = tracked.outline().m_reach + m_context.m_tolerance + m_slowMotion;
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
    else if (!tracked.m_jumped)
    {
        double time = m_motion == Motion::Done ? -remaining() : remaining();
        if (tracked.m_way != nullptr)
        {
            from = to = tracked.m_origin;  // where the step began
            time = m_timeStep;
        }
        to += tracked.m_course.m_velocity * btScalar(time);
    }
    if (!std::isfinite(tracked.m_motion) || !std::isfinite(from.length2()))
    {
        tracked.m_tracked = false;
        return;
    }
    const btVector3 around = btVector3(1, 1, 1) * btScalar(reach);
    btCcdBox& box = tracked.m_sweep;
    box = {from, from};
    box.m_low.setMin(to);
    box.m_high.setMax(to);
    box.m_low -= around;
    box.m_high += around;
    if (tracked.m_sweptAt >= 0)
    {
        m_swept.set(tracked.m_sweptAt, box);
    }
}

/// What the object, which has changed, may meet now: by the lists of neighbours while it keeps to
/// its place in them, else by all that it sweeps.
void btCcdStepper::addCandidates(int index)
{
    btCcdTracked& tracked = at(index);
    if (!tracked.m_tracked)
    {
        return;
    }
    if (m_tracker->isInBoxes() || m_tracker->listsAll())
    {
        addSwept(index);
        return;
    }
    if (!tracked.m_isStray &&
        (m_motion == Motion::Done || !m_tracker->staysInPlace(tracked, m_time, remaining())))
    {
        m_tracker->stray(tracked);
    }
    if (tracked.m_isStray)
    {
        addSwept(index);
    }
    else
    {
        addNear(index);
    }
}

/// False if the other is not in the box that the object sweeps, which has room for slow motion.
bool btCcdStepper::sweepsTo(const btCcdTracked& tracked, const btCcdTracked& other)
{
    if (other.m_fast)
    {
        return tracked.m_sweep.meets(other.m_sweep);
    }
    const btBroadphaseProxy* proxy = other.m_object->getBroadphaseHandle();
    return proxy != nullptr && tracked.m_sweep.meets({proxy->m_aabbMin, proxy->m_aabbMax});
}

/// Of two that have changed, the pair comes once: with the one that is fast, or the older one.
void btCcdStepper::addNear(int index)
{
    listNear();
    const btCcdTracked& tracked = at(index);
    const auto add = [&](int other)
    {
        const btCcdTracked& b = at(other);
        const bool isMine = tracked.m_fast == b.m_fast ? index < other : tracked.m_fast;
        if (other != index && (tracked.m_fast || b.m_fast) && (!b.m_changed || isMine) &&
            sweepsTo(tracked, b))
        {
            addPair(index, other);
        }
    };
    const std::size_t begin = index > 0 ? m_nearEnds[std::size_t(index) - 1] : 0;
    for (std::size_t i = begin; i < m_nearEnds[std::size_t(index)]; ++i)
    {
        if (!at(m_near[i]).m_isStray)
        {
            add(m_near[i]);
        }
    }
    for (const int stray : m_tracker->strays())
    {
        add(stray);
    }
}

/// The pairs of the lists, by object, once in a step.
void btCcdStepper::listNear()
{
    if (m_isNearListed)
    {
        return;
    }
    m_isNearListed = true;
    m_nearEnds.assign(m_tracker->objects().size() + 1, 0);
    const auto forEnds = [this](const auto& visit)
    {
        for (const auto* pairs : {&m_tracker->movers(), &m_tracker->others()})
        {
            for (const btCcdNeighbourPair& pair : *pairs)
            {
                visit(indexOf(*pair.m_a), indexOf(*pair.m_b));
                visit(indexOf(*pair.m_b), indexOf(*pair.m_a));
            }
        }
    };
    forEnds([this](int from, int) { ++m_nearEnds[std::size_t(from) + 1]; });
    std::partial_sum(m_nearEnds.begin(), m_nearEnds.end(), m_nearEnds.begin());
    m_near.resize(m_nearEnds.back());
    // Every begin is its end by then.
    forEnds([this](int from, int to) { m_near[m_nearEnds[std::size_t(from)]++] = to; });
}

/// True if what the object may meet is known from its m_sweep, and not from the broadphase.
bool btCcdStepper::sweepsBox(const btCcdTracked& tracked) const
{
    return m_tracker->isInBoxes() ? tracked.m_isStray : tracked.m_fast;
}

void btCcdStepper::listSwept(const std::vector<int>& objects)
{
    for (auto i = std::size_t(m_swept.size()); i < objects.size(); ++i)
    {
        btCcdTracked& tracked = at(objects[i]);
        tracked.m_sweptAt = int(i);
        m_swept.add(tracked.m_sweep);
    }
}

void btCcdStepper::addSwept(int index)
{
    const btCcdTracked& tracked = at(index);
    const bool isInBoxes = m_tracker->isInBoxes();
    const std::vector<int>& others = isInBoxes ? m_tracker->strays() : m_fast;
    listSwept(others);
    for (const int i : m_swept.meeting(tracked.m_sweep))
    {
        const int other = others[std::size_t(i)];
        const btCcdTracked& b = at(other);
        // Of two objects that come this way, the pair comes once.
        const bool first = ((tracked.m_fast || isInBoxes) && index < other) || !b.m_changed;
        if (other != index && first && b.m_tracked && (tracked.m_fast || b.m_fast))
        {
            addPair(index, other);
        }
    }
    if (!tracked.m_fast && !isInBoxes)
    {
        return;
    }
    if (isInBoxes || !m_fewSlow)
    {
        Candidates candidates(*this, index);
        m_world.getBroadphase()->aabbTest(
            tracked.m_sweep.m_low, tracked.m_sweep.m_high, candidates);
        return;
    }
    for (const int other : m_slow)
    {
        const btCcdTracked& b = at(other);
        if (!b.m_fast && sweepsTo(tracked, b))
        {
            addPair(index, other);
        }
    }
}

void btCcdStepper::addPair(int a, int b)
{
    // The order in which Bullet sees the pair: by the age of the objects.
    const auto [first, second] = std::minmax(a, b);
    const btCcdTracked& older = at(first);
    const btCcdTracked& newer = at(second);
    if (!wanted(older, newer) || !canCross(older, newer, btCcdMayLose(m_context, older, newer)))
    {
        return;
    }
    m_progress.bring(*older.m_object);
    m_progress.bring(*newer.m_object);
    if (const double time = boxesMeet(older, newer); time < kNever)
    {
        push(first, second, time).m_isLooked = false;
    }
}

/// What has changed often changes again before it is the turn of its pairs: only then they are
/// looked at along a direction, which costs more than boxes.
void btCcdStepper::look(Pair& pair)
{
    pair.m_isLooked = true;
    const btCcdTracked& a = at(pair.m_a);
    const btCcdTracked& b = at(pair.m_b);
    m_progress.bring(*a.m_object);
    m_progress.bring(*b.m_object);
    pair.m_time = std::max(pair.m_time, approach(a, b));
    pair.m_isAsked = pair.m_time == kNever;
}

/// One is squeezed, and the other cannot be stopped.
bool btCcdStepper::isSqueezed(const btCcdTracked& a, const btCcdTracked& b)
{
    return (a.m_squeezed && b.m_object->isStaticOrKinematicObject()) ||
           (b.m_squeezed && a.m_object->isStaticOrKinematicObject());
}

bool btCcdStepper::wanted(const btCcdTracked& a, const btCcdTracked& b) const
{
    return a.m_tracked && b.m_tracked && a.m_object != b.m_object &&
           (a.m_motion > 0.0 || b.m_motion > 0.0) && !isSqueezed(a, b) &&
           btCcdMayMeet(m_world, *a.m_object, *b.m_object) &&
           (m_listener == nullptr || m_listener->isSwept(*a.m_object, *b.m_object));
}

/// A pair that is to be asked, with all that changes nothing for another one.
struct btCcdStepper::Question
{
    Pair& m_pair;
    btCollisionObject* m_a;
    btCollisionObject* m_b;
    btCollisionAlgorithm* m_algorithm;
    bool m_isMade;  // for this question
    btCcdImpactResult m_result{};
    double m_fraction = 1.0;
};

/// True for meshes with the library's own algorithm, whose queries take long and may be asked on
/// several threads; but not for large ones that are converted piece by piece meanwhile.
bool btCcdStepper::isForThreads(const Question& question) const
{
    const auto isOf = [this](const btCollisionObject& object)
    {
        const btCcdShapeModel* model = m_context.model(object.getCollisionShape());
        return model != nullptr && std::ranges::none_of(model->m_parts,
                                                        [](const btCcdShapePart& part)
                                                        { return part.m_tiles != nullptr; });
    };
    const bool hasMesh = std::as_const(*m_tracker).find(*question.m_a)->outline().m_hasMesh ||
                         std::as_const(*m_tracker).find(*question.m_b)->outline().m_hasMesh;
    return hasMesh && dynamic_cast<btCcdCollisionAlgorithm*>(question.m_algorithm) != nullptr &&
           isOf(*question.m_a) && isOf(*question.m_b);
}

btCcdStepper::Question btCcdStepper::questionOf(Pair& pair)
{
    btCollisionObject* a = at(pair.m_a).m_object;
    btCollisionObject* b = at(pair.m_b).m_object;
    const btBroadphasePair* known =
        m_world.getPairCache()->findPair(a->getBroadphaseHandle(), b->getBroadphaseHandle());
    Question question{pair, a, b, known != nullptr ? known->m_algorithm : nullptr, false};
    if (question.m_algorithm == nullptr)
    {
        const btCollisionObjectWrapper wrapA(
            nullptr, a->getCollisionShape(), a, a->getWorldTransform(), -1, -1);
        const btCollisionObjectWrapper wrapB(
            nullptr, b->getCollisionShape(), b, b->getWorldTransform(), -1, -1);
        question.m_algorithm = m_world.getDispatcher()->findAlgorithm(
            &wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
        question.m_isMade = true;
    }
    return question;
}

/// Results do not depend on the number of threads.
void btCcdStepper::ask(std::span<Question> questions)
{
    m_context.m_motions = this;
    const auto ask = [this](Question& question)
    {
        btDispatcherInfo info = m_world.getDispatchInfo();
        info.m_timeStep = btScalar(remaining());
        question.m_fraction = double(question.m_algorithm->calculateTimeOfImpact(
            question.m_a, question.m_b, info, &question.m_result));
    };
    if (questions.size() > 1)
    {
        // Reading a motion may move its object.
        for (const Question& question : questions)
        {
            (void)motionOf(*question.m_a);
            (void)motionOf(*question.m_b);
        }
        // One that waits for a hierarchy to be built answers no other one meanwhile.
        const auto askAlone = [&](std::size_t i)
        { tbb::this_task_arena::isolate([&] { ask(questions[i]); }); };
        tbb::parallel_for(std::size_t(0), questions.size(), askAlone);
    }
    else
    {
        std::ranges::for_each(questions, ask);
    }
    m_context.m_motions = nullptr;
    for (const Question& question : questions)
    {
        if (question.m_isMade)
        {
            question.m_algorithm->~btCollisionAlgorithm();
            m_world.getDispatcher()->freeCollisionAlgorithm(question.m_algorithm);
        }
        Pair& pair = question.m_pair;
        pair.m_toi = question.m_result.m_toi;
        ++m_counts.m_queries;
        m_counts.m_overlaps += pair.m_toi.m_status == bullet_ccd::ToiStatus::Overlapping ? 1 : 0;
        m_tracker->noteDeep(pair.m_a, pair.m_b, pair.m_toi.m_isDeep);
        pair.m_isAsked = true;
        pair.m_time =
            question.m_fraction < 1.0 ? m_time + question.m_fraction * remaining() : kNever;
    }
}

/// The earliest time of impact; asks for all pairs that may come before, or with it.
double btCcdStepper::askEarliest()
{
    double earliest = kNever;
    std::vector<std::pair<double, int>> waiting;
    for (const Pair& pair : m_pairs)
    {
        if (pair.m_isAsked)
        {
            earliest = std::min(earliest, pair.m_time);
        }
    }
    for (std::size_t i = 0; i < m_pairs.size(); ++i)
    {
        const Pair& pair = m_pairs[i];
        if (!pair.m_isAsked && pair.m_time - pair.m_window <= earliest)
        {
            waiting.emplace_back(pair.m_time - pair.m_window, int(i));
        }
    }
    std::make_heap(waiting.begin(), waiting.end(), std::greater<>());
    std::vector<Question> several;
    const auto take = [&](std::span<Question> questions)
    {
        ask(questions);
        for (const Question& question : questions)
        {
            earliest = std::min(earliest, question.m_pair.m_time);
        }
    };
    for (;;)
    {
        const bool isDone = waiting.empty() || waiting.front().first > earliest;
        if (isDone && several.empty())
        {
            return earliest;
        }
        if (isDone || several.size() == kAtOnce)
        {
            take(several);
            several.clear();
            continue;
        }
        Pair& pair = m_pairs[std::size_t(waiting.front().second)];
        std::pop_heap(waiting.begin(), waiting.end(), std::greater<>());
        if (!pair.m_isLooked)
        {
            look(pair);
            waiting.back().first = pair.m_time - pair.m_window;
            std::push_heap(waiting.begin(), waiting.end(), std::greater<>());
            continue;
        }
        waiting.pop_back();
        if (pair.m_isAsked)
        {
            continue;  // the look has told
        }
        Question question = questionOf(pair);
        if (isForThreads(question))
        {
            several.push_back(question);
        }
        else
        {
            take({&question, 1});
        }
    }
}

btCcdStepper::Event btCcdStepper::next()
{
    BT_PROFILE("btCcdStepper::next");
    Event event;
    const double earliest = askEarliest();
    if (earliest == kNever)
    {
        return event;
    }
    event.m_found = true;
    event.m_time = std::clamp(btCcdRoundDown(earliest), btScalar(m_time), btScalar(m_timeStep));
    for (Pair& pair : m_pairs)
    {
        if (pair.m_isAsked && pair.m_time - pair.m_window <= earliest)
        {
            event.m_gaveUp = event.m_gaveUp || bullet_ccd::gaveUp(pair.m_toi.m_status);
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
    btCollisionObject* a = at(pair.m_a).m_object;
    btCollisionObject* b = at(pair.m_b).m_object;
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
    // What is fixed goes on as before: its other pairs keep their answers.
    if (btMultiBodyLinkCollider::upcast(&object) == nullptr && object.isStaticObject() &&
        !object.isKinematicObject())
    {
        return;
    }
    forParts(object,
             [this](btCcdTracked& part)
             {
                 note(part);
                 part.m_stopped =
                     part.m_stopped || (m_motion == Motion::Done && part.m_way == nullptr);
             });
}

void btCcdStepper::goesOn(const btCollisionObject& object)
{
    m_starts.erase(&object);
    forParts(object, [](btCcdTracked& part) { part.m_stopped = false; });
}

void btCcdStepper::squeezed(const btCollisionObject& object)
{
    forParts(object,
             [this](btCcdTracked& part)
             {
                 note(part);
                 part.m_squeezed = true;
             });
}

void btCcdStepper::note(btCcdTracked& tracked)
{
    if (!tracked.m_changed)
    {
        tracked.m_changed = true;
        m_changed.push_back(indexOf(tracked));
        if (m_tracker->isInBoxes())
        {
            m_tracker->stray(tracked);  // its box may be another one by now, too
        }
    }
}

/// False if the object moves on as it did.
bool btCcdStepper::takeNewCourse(btCcdTracked& tracked)
{
    const btCcdCourse course = m_tracker->courseOf(tracked);
    if (btMultiBodyLinkCollider::upcast(tracked.m_object) == nullptr &&
        course.m_velocity == tracked.m_course.m_velocity &&
        course.m_spin == tracked.m_course.m_spin)
    {
        return false;
    }
    tracked.take(course, m_time, remaining());
    const double way = norm(tracked.m_shift) + tracked.m_turned + tracked.m_motion;
    if (!tracked.m_fast && (way > tracked.m_slow || way > m_slowMotion ||
                            (tracked.m_pressed && tracked.m_motion > 0.0)))
    {
        // From now on it is not where the broadphase saw it.
        tracked.m_fast = true;
        m_fast.push_back(indexOf(tracked));
    }
    return true;
}

void btCcdStepper::refresh()
{
    BT_PROFILE("btCcdStepper::refresh");
    ++m_epoch;
    m_multiBodyCount = 0;
    m_tracker->forgetBodies();
    // What the last refresh() saw is still there, without a mark.
    std::sort(m_changed.begin(), m_changed.end());
    m_changed.erase(std::unique(m_changed.begin(), m_changed.end()), m_changed.end());
    const bool isInBoxes = m_tracker->isInBoxes();
    std::erase_if(m_changed,
                  [this, isInBoxes](int index)
                  {
                      btCcdTracked& tracked = at(index);
                      if (isInBoxes)
                      {
                          sweep(tracked);
                      }
                      tracked.m_changed = tracked.m_changed && tracked.m_tracked &&
                                          (takeNewCourse(tracked) || tracked.m_squeezed);
                      return !tracked.m_changed;
                  });
    for (const int index : m_changed)
    {
        sweep(at(index));
    }
    std::erase_if(m_pairs,
                  [&](const Pair& pair)
                  {
                      const btCcdTracked& a = at(pair.m_a);
                      const btCcdTracked& b = at(pair.m_b);
                      return a.m_changed || b.m_changed || pair.m_time == kNever ||
                             (pair.m_met && !wanted(a, b));
                  });
    const std::size_t before = m_pairs.size();
    for (const int index : m_changed)
    {
        addCandidates(index);
    }
    for (std::size_t i = 0; i < before; ++i)
    {
        if (m_pairs[i].m_met)
        {
            m_pairs[i].m_met = false;
            m_pairs[i].m_isAsked = false;
            m_pairs[i].m_time = m_time;
        }
    }
    for (const int index : m_changed)
    {
        at(index).m_changed = false;
    }
}

void btCcdStepper::end()
{
    m_context.m_shapes.endRound();
}

bool btCcdStepper::sweptBox(const btCollisionObject& object, btVector3& low, btVector3& high)
{
    btCcdTracked* tracked = m_tracker->find(object);
    if (tracked == nullptr || !tracked->m_tracked ||
        !(tracked->m_fast || tracked->m_motion > tracked->m_slow))
    {
        return false;
    }
    if (!tracked->m_fast)
    {
        // Nothing was in its way, so nothing was asked. By now it is where the step ended.
        m_motion = Motion::Done;
        m_time = 0.0;
        sweep(*tracked);
    }
    low = tracked->m_sweep.m_low;
    high = tracked->m_sweep.m_high;
    return true;
}
