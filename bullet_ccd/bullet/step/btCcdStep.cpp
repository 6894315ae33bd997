#include "bullet_ccd/bullet/step/btCcdStep.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdStopLink.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

namespace
{
/// After so many impacts of one pair in a step, contact is no longer taken for a bounce.
constexpr int kBounces = 2;
/// A body chatters after this part of its impacts of a step; what is left of its spin then.
constexpr int kChatter = 3;
constexpr btScalar kCalm = btScalar(0.5);
/// How often a body is settled beyond its limit of impacts before it is held.
constexpr int kSettlings = 4;

/// The kinematic objects of impacts, where they are in the middle of the step: Bullet leaves them
/// where the step began for it.
class KinematicInPlace
{
public:
    KinematicInPlace(const std::vector<btCcdImpact>& impacts, btCcdStepper& stepper)
    {
        for (const btCcdImpact& impact : impacts)
        {
            for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
            {
                const bool linked = btMultiBodyLinkCollider::upcast(object) != nullptr;
                const btCcdObjectMotion* motion =
                    object->isKinematicObject() && !linked ? stepper.motionOf(*object) : nullptr;
                if (motion != nullptr)
                {
                    m_saved.emplace_back(object, object->getWorldTransform());
                    object->setWorldTransform(btCcdToBullet(btCcdShapePoseAt(*motion, 0.0)));
                }
            }
        }
    }
    ~KinematicInPlace()
    {
        for (const auto& [object, pose] : m_saved)
        {
            object->setWorldTransform(pose);
        }
    }
    KinematicInPlace(const KinematicInPlace&) = delete;
    KinematicInPlace& operator=(const KinematicInPlace&) = delete;

private:
    std::vector<std::pair<btCollisionObject*, btTransform>> m_saved;
};
}  // namespace

btCcdStep::btCcdStep(btDiscreteDynamicsWorld& world)
    : m_world(world), m_stepper(world), m_solver(world), m_spins(world)
{
    m_stepper.prepare();
}

double btCcdStep::lostTime(const btCollisionObject* object) const
{
    const auto found = m_lostTimes.find(btCcdBody::of(const_cast<btCollisionObject*>(object)));
    return found != m_lostTimes.end() ? found->second : 0.0;
}

void btCcdStep::resetCounters()
{
    m_counters = {};
    m_lostTimes.clear();
}

bool btCcdStep::begin(btScalar timeStep)
{
    m_lastImpacts.clear();
    const bool found = m_stepper.begin(timeStep, btCcdStepper::Motion::ToCome);
    m_counters.m_unsupported = m_stepper.unsupported();
    if (m_stepper.seesStockClamping())
    {
        suspendStockClamping();
    }
    if (!found)
    {
        return false;
    }
    m_solver.beginStep();
    // What turns no faster than Bullet turns it may meet less.
    if (!m_spins.limit(timeStep) || m_stepper.begin(timeStep, btCcdStepper::Motion::ToCome))
    {
        m_stepper.askAll();
    }
    return true;
}

void btCcdStep::integrate(btScalar timeStep, const Integrate& integrate)
{
    btScalar elapsed = 0;
    while (elapsed < timeStep)
    {
        const btCcdStepper::Event event = m_stepper.next();
        const btScalar advance = (event.m_found ? event.m_time : timeStep) - elapsed;
        integrateInPieces(advance, integrate);
        if (!event.m_found)
        {
            break;
        }
        elapsed = std::max(elapsed, event.m_time);
        m_stepper.advance(elapsed);
        respond(event, timeStep - elapsed);
        m_stepper.refresh();
    }
    releaseHeld();
    m_events.clear();
    m_pairEvents.clear();
    m_spins.endStep();
    countQueries();
}

/// An impact may leave a body spinning faster than Bullet's integrator turns it in one call.
void btCcdStep::integrateInPieces(btScalar time, const Integrate& integrate)
{
    if (!(time > btScalar(0)))
    {
        return;
    }
    const int pieces = m_spins.pieces(time);
    for (int i = 0; i < pieces; ++i)
    {
        integrate(time / btScalar(pieces));
    }
}

void btCcdStep::rollBack(btScalar timeStep)
{
    m_lastImpacts.clear();
    if (m_stepper.begin(timeStep, btCcdStepper::Motion::Done))
    {
        m_stepper.askAll();
        for (btCcdStepper::Event event = m_stepper.next(); event.m_found; event = m_stepper.next())
        {
            m_stepper.advance(event.m_time);
            const btScalar remaining = timeStep - event.m_time;
            for (const btCcdImpact& impact : event.m_impacts)
            {
                placeBack(impact.m_objectA, remaining);
                placeBack(impact.m_objectB, remaining);
                note(impact);
                m_stepper.changed(*impact.m_objectA);
                m_stepper.changed(*impact.m_objectB);
            }
            m_counters.m_iterationLimits += event.m_gaveUp ? 1 : 0;
            for (const btCcdImpact& impact : event.m_impacts)
            {
                if (m_listener != nullptr)
                {
                    m_listener->onImpact(impact);
                }
                stopWatchedLink(impact.m_objectA, impact.m_linkA);
                stopWatchedLink(impact.m_objectB, impact.m_linkB);
            }
            m_stepper.refresh();
        }
        m_events.clear();
        countQueries();
    }
    m_counters.m_unsupported = m_stepper.unsupported();
}

void btCcdStep::countQueries()
{
    const btCcdStepper::Counts& counts = m_stepper.counts();
    m_counters.m_queries += counts.m_queries;
    m_counters.m_overlaps += counts.m_overlaps;
    m_stepper.end();
}

/// It would stop bodies short of where the queries take them to be.
void btCcdStep::suspendStockClamping()
{
    const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
    for (int i = 0; i < bodies.size(); ++i)
    {
        btRigidBody* body = bodies[i];
        if (body->getCcdMotionThreshold() != btScalar(0) && m_stepper.covers(*body))
        {
            m_stockThresholds.emplace_back(body, body->getCcdMotionThreshold());
            body->setCcdMotionThreshold(btScalar(0));
        }
    }
}

void btCcdStep::end()
{
    if (m_stockThresholds.empty())
    {
        return;
    }
    for (const auto& [body, threshold] : m_stockThresholds)
    {
        body->setCcdMotionThreshold(threshold);
    }
    m_stockThresholds.clear();
}

void btCcdStep::releaseHeld()
{
    for (const btCcdVelocities& held : m_held)
    {
        held.restore();
    }
    m_held.clear();
}

void btCcdStep::respond(const btCcdStepper::Event& event, btScalar remaining)
{
    m_spins.free(m_stepper);
    std::vector<btCcdImpact> bouncing;
    std::vector<btCcdImpact> again;
    for (const btCcdImpact& impact : event.m_impacts)
    {
        note(impact);
        m_stepper.changed(*impact.m_objectA);
        m_stepper.changed(*impact.m_objectB);
        if (event.m_gaveUp)
        {
            ++m_counters.m_iterationLimits;
            hold(impact.m_objectA, remaining);
            hold(impact.m_objectB, remaining);
        }
        else if (!isDone(impact, remaining))
        {
            const int met = m_pairEvents[std::minmax<const btCollisionObject*>(impact.m_objectA,
                                                                               impact.m_objectB)]++;
            (met < kBounces ? bouncing : again).push_back(impact);
        }
    }
    const KinematicInPlace kinematic(event.m_impacts, m_stepper);
    solve(bouncing, true);
    for (const btCcdImpact& impact : again)
    {
        calmDown(impact.m_objectA);
        calmDown(impact.m_objectB);
    }
    solve(again, false);
}

/// A body that chatters (a third of its impacts of the step are used up) loses its spin: to take
/// the rattle of something small and fast for inelastic costs energy, to hold it would cost time.
void btCcdStep::calmDown(btCollisionObject* object)
{
    const btCcdBody body = btCcdBody::of(object);
    if (body.isNone() || object->isStaticOrKinematicObject() ||
        m_events[body] <= m_maxEvents / kChatter)
    {
        return;
    }
    body.calm(kCalm);
}

/// True if the listener, a stopped link or the limit of impacts has the last word.
bool btCcdStep::isDone(const btCcdImpact& impact, btScalar remaining)
{
    const btCcdAfterImpact answer =
        m_listener != nullptr ? m_listener->onImpact(impact) : btCcdAfterImpact::Solve;
    const bool stoppedA = stopWatchedLink(impact.m_objectA, impact.m_linkA);
    const bool stoppedB = stopWatchedLink(impact.m_objectB, impact.m_linkB);
    const bool limit = meetsLimit(impact);
    if (limit && answer != btCcdAfterImpact::Hold && settle(impact))
    {
        return true;
    }
    if (limit || answer == btCcdAfterImpact::Hold)
    {
        hold(impact.m_objectA, remaining);
        hold(impact.m_objectB, remaining);
        return true;
    }
    return answer == btCcdAfterImpact::Continue || stoppedA || stoppedB;
}

/// What the solver could not part in so many impacts goes on without spin (a multibody: without the
/// motion of its joints, too) and without approach: for convex bodies that ends it, and costs no
/// time. False if it was in vain.
bool btCcdStep::settle(const btCcdImpact& impact)
{
    btScalar approach = 0;
    btScalar mobility = 0;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        if (m_events[body] > m_maxEvents + kSettlings)
        {
            return false;
        }
        const btScalar side = object == impact.m_objectA ? btScalar(1) : btScalar(-1);
        approach += side * body.velocity().dot(impact.m_normal);
        mobility += body.mobility();
    }
    const btScalar impulse =
        mobility > btScalar(0) ? std::max(approach, btScalar(0)) / mobility : btScalar(0);
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btScalar side = object == impact.m_objectA ? btScalar(-1) : btScalar(1);
        btCcdBody::of(object).slide(side * impulse * impact.m_normal);
    }
    return true;
}

bool btCcdStep::meetsLimit(const btCcdImpact& impact)
{
    bool meets = false;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        const bool moves = !body.isNone() && !object->isStaticOrKinematicObject();
        meets = meets || (moves && ++m_events[body] > m_maxEvents);
    }
    m_counters.m_eventLimits += meets ? 1 : 0;
    return meets;
}

void btCcdStep::solve(const std::vector<btCcdImpact>& impacts, bool bouncing)
{
    if (impacts.empty())
    {
        return;
    }
    ++m_counters.m_subSteps;
    for (btCollisionObject* object : m_solver.solve(impacts, bouncing))
    {
        m_spins.add(btCcdBody::of(object));
        m_stepper.changed(*object);
    }
}

bool btCcdStep::stopWatchedLink(const btCollisionObject* object, int link)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(object);
    if (collider == nullptr)
    {
        return false;
    }
    const auto watched = m_stopLinks.find({collider->m_multiBody, link});
    if (watched == m_stopLinks.end())
    {
        return false;
    }
    m_stopLinks.erase(watched);
    return btCcdStopLink(*collider->m_multiBody, link);
}

void btCcdStep::hold(btCollisionObject* object, btScalar remaining)
{
    const btCcdBody body = btCcdBody::of(object);
    const bool moves = body.m_multiBody != nullptr || !object->isStaticOrKinematicObject();
    if (body.isNone() || !moves || body.isStill())
    {
        return;  // stands, or is held already
    }
    m_held.emplace_back(body);
    btCcdStop(body);
    countHold(body, remaining);
}

/// Undoes the last `remaining` seconds of the body's motion; once a step.
void btCcdStep::placeBack(btCollisionObject* object, btScalar remaining)
{
    const btCcdBody body = btCcdBody::of(object);
    if (body.isNone() || ++m_events[body] > 1)
    {
        return;
    }
    if (btMultiBody* multiBody = body.m_multiBody)
    {
        if (body.isStill() || !btCcdIsStepped(*multiBody))
        {
            return;
        }
        if (const btCcdMultiBodyMotion* motion = m_stepper.multiBodyMotionOf(*object))
        {
            btCcdPlaceAtStart(*multiBody, *motion);
            countHold(body, remaining);
        }
        return;
    }
    btRigidBody* rigidBody = body.m_rigidBody;
    const btCcdObjectMotion* motion =
        rigidBody->isStaticOrKinematicObject() ? nullptr : m_stepper.motionOf(*object);
    if (motion != nullptr)
    {
        rigidBody->setCenterOfMassTransform(btCcdToBullet(btCcdShapePoseAt(*motion, 0.0)));
        countHold(body, remaining);
    }
}

void btCcdStep::countHold(const btCcdBody& body, btScalar remaining)
{
    ++m_counters.m_clamps;
    m_counters.m_lostTime += double(remaining);
    m_lostTimes[body] += double(remaining);
}

void btCcdStep::note(const btCcdImpact& impact)
{
    ++m_counters.m_impacts;
    m_lastImpacts.push_back(
        {impact, impact.m_objectA->getWorldTransform(), impact.m_objectB->getWorldTransform()});
}
