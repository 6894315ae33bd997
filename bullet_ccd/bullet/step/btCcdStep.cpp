#include "bullet_ccd/bullet/step/btCcdStep.h"

#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdTracker.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <array>

namespace
{
/// After so many impacts of one pair in a step, contact is no longer taken for a bounce.
constexpr int kBounces = 2;
/// A body chatters after this part of its impacts of a step; what is left of its spin then.
constexpr int kChatter = 3;
constexpr btScalar kCalm = btScalar(0.5);
/// How often a body is settled beyond its limit of impacts before it is held.
constexpr int kSettlings = 4;
/// How often a body is carried along anew before it is squeezed, and how often it gets away from
/// the carrier by twice as much as before.
constexpr int kCarries = 12;
constexpr int kFarAway = 6;
/// What a body that is carried gets away by at first, relative to the tolerance, and beside that
/// relative to how far it would be off a circle.
constexpr double kAway = 0.01;
/// Impacts that come within this part of the step come at one time.
constexpr btScalar kInstant = btScalar(1e-6);
/// So many impacts are remembered.
constexpr std::size_t kMostSeen = 1000;
/// The action: a body that meets something in more than so many steps is stuck, until it has met
/// nothing in as many steps as this. The worlds: the same of what met its limit.
constexpr int kStuck = 2;
constexpr int kForgotten = 16;
/// If that came within the first part of the step, in more steps in a row, it is jammed between
/// others, which only what it cannot do keeps at their speed: it is slowed down by this part in
/// every step.
constexpr btScalar kFirstPart = btScalar(1.0 / 16.0);
constexpr int kHeld = 2;
constexpr int kJammed = 4;
/// How often a body goes on beside a kinematic object before it is carried along.
constexpr int kPushes = 2;
/// How often the solver answers for a body in a step, at most.
constexpr int kSolvings = 12;
constexpr btScalar kDrag = btScalar(0.5);

/// The kinematic objects that an impact or the solver comes by, where they are in the middle of the
/// step: Bullet leaves them where the step began for it. One that moves without a velocity gets
/// that of its way.
class KinematicInPlace
{
public:
    KinematicInPlace(const std::vector<btCcdImpact>& impacts,
                     btCcdStepper& stepper,
                     btCcdProgress& progress,
                     btScalar remaining)
        : m_stepper(stepper), m_progress(progress), m_remaining(remaining)
    {
        m_progress.setPlaceKinematic([this](const btCollisionObject& object) { place(object); });
        for (const btCcdImpact& impact : impacts)
        {
            place(*impact.m_objectA);
            place(*impact.m_objectB);
        }
    }
    ~KinematicInPlace()
    {
        m_progress.setPlaceKinematic({});
        for (const Saved& saved : m_saved)
        {
            saved.m_body->setWorldTransform(saved.m_pose);
            saved.m_body->setLinearVelocity(saved.m_velocity);
            saved.m_body->setAngularVelocity(saved.m_spin);
        }
    }
    KinematicInPlace(const KinematicInPlace&) = delete;
    KinematicInPlace& operator=(const KinematicInPlace&) = delete;

private:
    struct Saved
    {
        btRigidBody* m_body;
        btTransform m_pose;
        btVector3 m_velocity;
        btVector3 m_spin;
    };
    btCcdStepper& m_stepper;
    btCcdProgress& m_progress;
    btScalar m_remaining;
    std::vector<Saved> m_saved;

    void place(const btCollisionObject& object)
    {
        btRigidBody* body = btRigidBody::upcast(const_cast<btCollisionObject*>(&object));
        if (body == nullptr || !body->isKinematicObject() ||
            std::ranges::any_of(m_saved, [=](const Saved& saved) { return saved.m_body == body; }))
        {
            return;
        }
        m_saved.push_back({body,
                           body->getWorldTransform(),
                           body->getLinearVelocity(),
                           body->getAngularVelocity()});
        // Asking for its motion comes here again.
        const btCcdObjectMotion* motion = m_stepper.motionOf(*body);
        if (motion == nullptr)
        {
            return;
        }
        body->setWorldTransform(btCcdToBullet(btCcdShapePoseAt(*motion, 0.0)));
        const auto* rigid = std::get_if<bullet_ccd::RigidMotion>(&motion->m_motion);
        if (rigid != nullptr && m_remaining > btScalar(0) && isStill(*body))
        {
            body->setLinearVelocity(btCcdToBullet(rigid->v_W) / m_remaining);
            body->setAngularVelocity(btCcdToBullet(rigid->w_W) / m_remaining);
        }
    }

    [[nodiscard]] static bool isStill(const btRigidBody& body)
    {
        const btVector3 zero(0, 0, 0);
        return body.getLinearVelocity() == zero && body.getAngularVelocity() == zero;
    }
};
}  // namespace

btCcdStep::btCcdStep(btDiscreteDynamicsWorld& world)
    : m_world(world),
      m_context(btCcdContext::of(*world.getDispatcher())),
      m_spins(world),
      m_progress(world, m_spins),
      m_stepper(world, m_progress),
      m_solver(world, m_progress),
      m_pushes(world),
      m_triggers(world)
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
    BT_PROFILE("btCcdStep::begin");
    m_lastImpacts.clear();
    ++m_step;
    m_impacts = 0;
    if (m_budget.m_seconds > 0.0)
    {
        m_begin = std::chrono::steady_clock::now();
    }
    m_stepper.newStep();
    const bool isPushed = !m_pushes.find(timeStep, false).empty();
    if (!m_pushes.far().empty())
    {
        notePushed();
    }
    if (isPushed)
    {
        takeBackPushes(timeStep);
    }
    const bool found = findImpacts(timeStep);
    beginTriggers(timeStep);
    return found;
}

bool btCcdStep::findImpacts(btScalar timeStep)
{
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
        m_stepper.getReady();
    }
    return true;
}

/// Most worlds have none.
inline void btCcdStep::beginTriggers(btScalar timeStep)
{
    if (m_triggers.isActive() || m_stepper.tracker().seesTriggers())
    {
        m_triggers.begin(m_stepper, timeStep);
    }
}

void btCcdStep::notePushed()
{
    for (const btRigidBody* body : m_pushes.far())
    {
        m_stepper.mayBePushed(*body);
    }
}

void btCcdStep::takeStarts()
{
    for (const btCcdPushes::Push& push : m_pushes.found())
    {
        m_stepper.startsAt(*push.m_body, push.m_from);
    }
}

/// A push that would lead through something ends there; everything else stands meanwhile.
void btCcdStep::takeBackPushes(btScalar timeStep)
{
    const btCcdPushed pushed(m_world, m_pushes.found(), true);
    takeStarts();
    if (!m_stepper.begin(timeStep, btCcdStepper::Motion::Done, true))
    {
        return;
    }
    m_stepper.getReady();
    for (btCcdStepper::Event event = m_stepper.next(); event.m_found; event = m_stepper.next())
    {
        m_stepper.advance(event.m_time);
        for (const btCcdImpact& impact : event.m_impacts)
        {
            for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
            {
                // Kinematic bodies stay where they have been put, with their velocities.
                const btCcdBody body{btRigidBody::upcast(object), nullptr};
                const btCcdObjectMotion* motion = m_stepper.motionOf(*object);
                if (body.isFree() && !body.isStill() && motion != nullptr)
                {
                    object->setWorldTransform(btCcdToBullet(btCcdShapePoseAt(*motion, 0.0)));
                    btCcdStop(body);
                }
                m_stepper.changed(*object);
            }
        }
        m_stepper.refresh();
    }
    countQueries();
}

void btCcdStep::teleported(const btCollisionObject& object)
{
    m_pushes.forget(object);
    m_stepper.teleported(object);
}

void btCcdStep::integrate(btScalar timeStep, const Integrate& integrate)
{
    m_timeStep = timeStep;
    forgetStuck();
    m_progress.begin(integrate);
    btScalar elapsed = 0;
    while (elapsed < timeStep)
    {
        const btCcdStepper::Event event = m_stepper.next();
        if (!event.m_found)
        {
            break;
        }
        elapsed = std::max(elapsed, event.m_time);
        m_progress.advance(elapsed);
        m_stepper.advance(elapsed);
        respond(event, timeStep - elapsed);
        m_stepper.refresh();
        m_triggers.changed(m_stepper, elapsed);
    }
    m_progress.finish(timeStep);
    releaseStopped();
    m_pairEvents.clear();
    m_spins.endStep();
    countQueries();
}

void btCcdStep::rollBack(btScalar timeStep)
{
    BT_PROFILE("btCcdStep::rollBack");
    m_lastImpacts.clear();
    ++m_step;
    m_timeStep = timeStep;
    m_impacts = 0;
    m_stepper.newStep();
    {
        std::optional<btCcdPushed> pushed;
        const bool isPushed = !m_pushes.find(timeStep, true).empty();
        if (!m_pushes.far().empty())
        {
            notePushed();
        }
        if (isPushed)
        {
            pushed.emplace(m_world, m_pushes.found(), false);
            takeStarts();
        }
        takeBack(timeStep);
        m_triggers.end();
    }
    m_pushes.noteEnd(m_stepper.tracker().seesKinematic());
    m_stepper.endStep();
    m_counters.m_unsupported = m_stepper.unsupported();
    m_triggers.tell(m_listener);
}

void btCcdStep::takeBack(btScalar timeStep)
{
    const bool found = m_stepper.begin(timeStep, btCcdStepper::Motion::Done);
    beginTriggers(timeStep);
    if (found)
    {
        forgetStuck();
        m_stepper.getReady();
        m_solver.beginStep();
        for (btCcdStepper::Event event = m_stepper.next(); event.m_found; event = m_stepper.next())
        {
            m_stepper.advance(event.m_time);
            const btScalar remaining = timeStep - event.m_time;
            const KinematicInPlace kinematic(event.m_impacts, m_stepper, m_progress, remaining);
            for (const btCcdImpact& impact : event.m_impacts)
            {
                placeBack(impact.m_objectA);
                placeBack(impact.m_objectB);
                note(impact);
            }
            for (const btCcdImpact& impact : event.m_impacts)
            {
                m_stepper.changed(*impact.m_objectA);
                m_stepper.changed(*impact.m_objectB);
            }
            answerBack(event, remaining);
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
            m_triggers.changed(m_stepper, event.m_time);
        }
        releaseStopped();
        countQueries();
    }
}

void btCcdStep::forgetStuck()
{
    std::erase_if(m_stuck,
                  [this](const auto& known) { return known.second.m_step < m_step - kForgotten; });
}

/// Two that meet are held. What is stuck, and what a kinematic object runs into, goes on.
void btCcdStep::answerBack(const btCcdStepper::Event& event, btScalar remaining)
{
    std::vector<btCcdImpact> stuck;
    std::vector<btCcdImpact> lying;
    bool isPressed = false;
    const auto holdBoth = [&](const btCcdImpact& impact)
    {
        holdBack(impact.m_objectA, remaining);
        holdBack(impact.m_objectB, remaining);
    };
    for (const btCcdImpact& impact : event.m_impacts)
    {
        const Stuck steps = countStuck(impact, event.m_time < kFirstPart * m_timeStep);
        if (isDriving(*impact.m_objectA) || isDriving(*impact.m_objectB))
        {
            if (steps.m_jams > kHeld && isFirstPush(impact))
            {
                m_pushes.giveOwnVelocity(*impact.m_objectA);
                m_pushes.giveOwnVelocity(*impact.m_objectB);
                lying.push_back(impact);
            }
            else
            {
                push(impact, remaining, steps.m_jams > kHeld);
            }
            continue;
        }
        if (carryAlong(impact, remaining))
        {
            continue;
        }
        if (event.m_gaveUp)
        {
            // Nothing lets them go again in this step.
            m_fates[btCcdBody::of(impact.m_objectA)].m_solvings = kSolvings;
            m_fates[btCcdBody::of(impact.m_objectB)].m_solvings = kSolvings;
        }
        if (event.m_gaveUp || (steps.m_count <= kStuck && !isPile(impact, event.m_impacts)))
        {
            holdBoth(impact);
            continue;
        }
        letGo(impact.m_objectA, remaining);
        letGo(impact.m_objectB, remaining);
        m_pushes.giveOwnVelocity(*impact.m_objectA);
        m_pushes.giveOwnVelocity(*impact.m_objectB);
        const bool isSolved = countSolving(impact);
        if (steps.m_jams > kJammed || !isSolved)
        {
            part(impact, steps.m_jams > kJammed ? kDrag : btScalar(0));
        }
        if (isSolved)
        {
            isPressed = isPressed || steps.m_jams > kHeld;
            stuck.push_back(impact);
        }
        else
        {
            holdBoth(impact);
        }
    }
    const btCcdAnswer answer = isPressed ? btCcdAnswer::Part : btCcdAnswer::Bounce;
    if (!stuck.empty() && !solveBack(stuck, answer, remaining))
    {
        std::for_each(stuck.begin(), stuck.end(), holdBoth);
    }
    if (!lying.empty() && !solveBack(lying, btCcdAnswer::Part, remaining))
    {
        for (const btCcdImpact& impact : lying)
        {
            push(impact, remaining, true);
        }
    }
    for (auto pushed = m_pushed.begin(); pushed != m_pushed.end(); ++pushed)
    {
        if (std::find(m_pushed.begin(), pushed, *pushed) == pushed)
        {
            goOn(*pushed, remaining);
        }
    }
    m_pushed.clear();
}

/// True for an impact with what has met something else in this step.
bool btCcdStep::isPile(const btCcdImpact& impact, const std::vector<btCcdImpact>& impacts)
{
    const auto meetsMore = [&](btCollisionObject* object)
    {
        const btCcdBody body = btCcdBody::of(object);
        const auto concerns = [&](const btCcdImpact& other) {
            return btCcdBody::of(other.m_objectA) == body || btCcdBody::of(other.m_objectB) == body;
        };
        return body.isFree() && body.m_rigidBody != nullptr &&
               (isStopped(m_fates[body]) || std::ranges::count_if(impacts, concerns) > 1);
    };
    return meetsMore(impact.m_objectA) || meetsMore(impact.m_objectB);
}

/// A rigid body that has been held in this step may go on, from the present time.
void btCcdStep::letGo(btCollisionObject* object, btScalar remaining)
{
    const btCcdBody body = btCcdBody::of(object);
    const auto fate = m_fates.find(body);
    if (body.m_rigidBody != nullptr && fate != m_fates.end() &&
        fate->second.m_yield == btCcdYield::Held)
    {
        fate->second.m_yield.reset();
        m_counters.m_lostTime -= double(remaining);
        m_lostTimes[body] -= double(remaining);
    }
}

/// True once in a step for a body that a kinematic object meets.
bool btCcdStep::isFirstPush(const btCcdImpact& impact)
{
    const btCcdBody bodyA = btCcdBody::of(impact.m_objectA);
    Fate& fate = m_fates[bodyA.isFree() ? bodyA : btCcdBody::of(impact.m_objectB)];
    return !fate.m_yield && fate.m_impacts++ == 0;
}

/// What a kinematic object has run into goes on beside it, then it is carried along, a few times,
/// and then it is squeezed. The solver answers in the next step, to the velocity at which they met.
void btCcdStep::push(const btCcdImpact& impact, btScalar remaining, bool isStuck)
{
    for (const int side : {0, 1})
    {
        btCollisionObject* object = side == 0 ? impact.m_objectA : impact.m_objectB;
        const btCollisionObject* other = side == 0 ? impact.m_objectB : impact.m_objectA;
        const btCcdBody body = btCcdBody::of(object);
        if (!body.isFree())
        {
            continue;
        }
        Fate& fate = m_fates[body];
        if (!isStuck && !fate.m_own)
        {
            fate.m_own.emplace(body);
        }
        if (body.m_rigidBody != nullptr && !fate.m_yield && ++fate.m_impacts <= kPushes)
        {
            part(impact, btScalar(0));
            m_pushed.push_back(object);
        }
        else if (body.m_rigidBody != nullptr && carry(impact, side, *other, remaining))
        {
            m_pushed.push_back(object);
        }
        else
        {
            holdBack(object, remaining);
            squeeze(impact, object);
        }
    }
}

/// What a body that is carried runs into is carried along, too: held, it would hold that body, and
/// the kinematic object would run it over. False if neither is carried, or that cannot be.
bool btCcdStep::carryAlong(const btCcdImpact& impact, btScalar remaining)
{
    const std::array<btCollisionObject*, 2> objects{impact.m_objectA, impact.m_objectB};
    if (!std::ranges::all_of(objects,
                             [](btCollisionObject* object)
                             {
                                 const btCcdBody body = btCcdBody::of(object);
                                 return body.isFree() && body.m_rigidBody != nullptr;
                             }))
    {
        return false;
    }
    const std::array fates{&m_fates[btCcdBody::of(objects[0])],
                           &m_fates[btCcdBody::of(objects[1])]};
    // The one that is farther from what carries it can give way.
    const int side = fates[0]->m_carrier == nullptr || (fates[1]->m_carrier != nullptr &&
                                                        fates[0]->m_chain > fates[1]->m_chain)
                         ? 0
                         : 1;
    const Fate& carried = *fates[std::size_t(1 - side)];
    if (carried.m_carrier == nullptr || !carry(impact, side, *carried.m_carrier, remaining))
    {
        return false;
    }
    fates[std::size_t(side)]->m_chain = carried.m_chain + 1;
    m_pushed.insert(m_pushed.end(), objects.begin(), objects.end());
    return true;
}

/// Answers as a world does, in the middle of the step, and everything in the island goes on from
/// there. False if that is not to be.
bool btCcdStep::solveBack(const std::vector<btCcdImpact>& impacts,
                          btCcdAnswer answer,
                          btScalar remaining)
{
    std::map<const btCollisionObject*, btTransform> ends;  // of what has been placed
    m_progress.setPlace(
        [&](const btCollisionObject& object)
        {
            // Asking for its motion comes here again.
            const bool isNew = ends.emplace(&object, object.getWorldTransform()).second;
            const bool isLink = btMultiBodyLinkCollider::upcast(&object) != nullptr;
            if (isNew && (isLink || !placeBack(const_cast<btCollisionObject*>(&object))))
            {
                ends.erase(&object);
            }
            m_pushes.giveOwnVelocity(object);
        });
    const std::vector<btCollisionObject*>& island = m_solver.solve(impacts, answer, true);
    m_progress.setPlace({});
    for (btCollisionObject* object : island)
    {
        if (ends.erase(object) != 0)
        {
            keepCarried(btCcdBody::of(object));
            m_stepper.changed(*object);
            goOn(object, remaining);
            std::erase(m_pushed, object);
        }
    }
    for (const auto& [object, end] : ends)
    {
        const_cast<btCollisionObject*>(object)->setWorldTransform(end);
    }
    return !island.empty();
}

/// True for a kinematic object that moves in this step.
bool btCcdStep::isDriving(const btCollisionObject& object)
{
    const bool linked = btMultiBodyLinkCollider::upcast(&object) != nullptr;
    const btCcdObjectMotion* motion =
        object.isKinematicObject() && !linked ? m_stepper.motionOf(object) : nullptr;
    const auto* rigid =
        motion != nullptr ? std::get_if<bullet_ccd::RigidMotion>(&motion->m_motion) : nullptr;
    return rigid != nullptr && !(rigid->v_W.isZero(0.0) && rigid->w_W.isZero(0.0));
}

/// From where it has been placed, at its velocity, if it has not been held.
void btCcdStep::goOn(btCollisionObject* object, btScalar remaining)
{
    const btCcdBody body = btCcdBody::of(object);
    if (!body.isFree() || body.m_rigidBody == nullptr || isStopped(m_fates[body]))
    {
        return;
    }
    const btVector3 turn =
        btCcdToBullet(btCcdTurn(body.m_rigidBody->getAngularVelocity(), m_timeStep));
    bullet_ccd::RigidMotion motion = bullet_ccd::restAt(btCcdToEigen(object->getWorldTransform()));
    motion.v_W = btCcdToEigen(body.m_rigidBody->getLinearVelocity() * remaining);
    motion.w_W = btCcdToEigen(turn * (remaining / m_timeStep));
    body.m_rigidBody->setCenterOfMassTransform(btCcdToBullet(motion.at(1.0).X_W));
    m_stepper.goesOn(*object);
}

/// True for what meets a kinematic object at once in several steps in a row. Bullet's contacts see
/// that object ahead: nothing else keeps the two at their distance.
bool btCcdStep::liesOnDriver(const btCcdImpact& impact)
{
    return (isDriving(*impact.m_objectA) || isDriving(*impact.m_objectB)) &&
           countStuck(impact, impact.m_time < kFirstPart * m_timeStep).m_jams > kHeld;
}

/// True for what met its limit at once in several steps in a row: two that have come so near that
/// they cannot even slide need their distance back.
bool btCcdStep::isJammed(const btCcdImpact& impact)
{
    const auto isOf = [this](btCollisionObject* object)
    {
        const auto known = m_stuck.find(btCcdBody::of(object));
        return known != m_stuck.end() && known->second.m_jams > kHeld &&
               known->second.m_jamStep >= m_step - 1;
    };
    return impact.m_time < kFirstPart * m_timeStep &&
           (isOf(impact.m_objectA) || isOf(impact.m_objectB));
}

/// In how many steps the body of the impact that met more has met something.
btCcdStep::Stuck btCcdStep::countStuck(const btCcdImpact& impact, bool isEarly)
{
    Stuck stuck;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        if (!body.isFree())
        {
            continue;
        }
        Stuck& known = m_stuck[body];
        if (known.m_step != m_step)
        {
            ++known.m_count;
            known.m_step = m_step;
        }
        if (isEarly && known.m_jamStep != m_step)
        {
            known.m_jams = known.m_jamStep == m_step - 1 ? known.m_jams + 1 : 1;
            known.m_jamStep = m_step;
        }
        stuck.m_count = std::max(stuck.m_count, known.m_count);
        stuck.m_jams = std::max(stuck.m_jams, isEarly ? known.m_jams : 0);
    }
    return stuck;
}

/// False if the solver has answered often enough for one of the two in this step.
bool btCcdStep::countSolving(const btCcdImpact& impact)
{
    bool isFree = true;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        isFree = !(body.isFree() && m_fates[body].m_solvings++ >= kSolvings) && isFree;
    }
    return isFree;
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
    m_triggers.end();
    m_pushes.noteEnd(m_stepper.tracker().seesKinematic());
    m_stepper.endStep();
    for (const auto& [body, threshold] : m_stockThresholds)
    {
        body->setCcdMotionThreshold(threshold);
    }
    m_stockThresholds.clear();
    m_triggers.tell(m_listener);
}

void btCcdStep::releaseStopped()
{
    for (const auto& [body, fate] : m_fates)
    {
        if (fate.m_after)
        {
            fate.m_after->restore();
        }
        else if (fate.m_own)
        {
            fate.m_own->restore();
        }
        // What is jammed and was held gathers no speed, though it falls and others push on it.
        const auto stuck = m_stuck.find(body);
        if (fate.m_yield == btCcdYield::Held && body.m_rigidBody != nullptr &&
            stuck != m_stuck.end() && stuck->second.m_jamStep == m_step &&
            stuck->second.m_jams > kJammed)
        {
            body.setVelocity(kDrag * body.velocity(), kDrag * body.spin(btCcdBody::kBase));
        }
    }
    m_fates.clear();
}

void btCcdStep::respond(const btCcdStepper::Event& event, btScalar remaining)
{
    BT_PROFILE("btCcdStep::respond");
    m_spins.forLimited([this](const btCollisionObject& object) { m_progress.bring(object); });
    m_spins.free(m_stepper);
    if (m_listener != nullptr)
    {
        m_progress.bringAll();
    }
    for (const btCcdImpact& impact : event.m_impacts)
    {
        m_progress.bring(*impact.m_objectA);
        m_progress.bring(*impact.m_objectB);
    }
    const KinematicInPlace kinematic(event.m_impacts, m_stepper, m_progress, remaining);
    std::vector<btCcdImpact> bouncing;
    std::vector<btCcdImpact> again;
    std::vector<btCcdImpact> lying;
    for (const btCcdImpact& impact : event.m_impacts)
    {
        note(impact);
        for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
        {
            m_stepper.changed(*object);
            m_spins.add(btCcdBody::of(object));
        }
        if (event.m_gaveUp)
        {
            ++m_counters.m_iterationLimits;
            yield(impact, remaining);
        }
        else if (!isDone(impact, remaining))
        {
            const int met = m_pairEvents[std::minmax<const btCollisionObject*>(impact.m_objectA,
                                                                               impact.m_objectB)]++;
            const bool lies = liesOnDriver(impact) || isJammed(impact);
            (lies ? lying : met < kBounces ? bouncing : again).push_back(impact);
        }
    }
    solve(lying, btCcdAnswer::Part);
    solve(bouncing, btCcdAnswer::Bounce);
    for (const btCcdImpact& impact : again)
    {
        calmDown(impact.m_objectA);
        calmDown(impact.m_objectB);
    }
    solve(again, btCcdAnswer::Calm);
    m_spins.limitAgain(remaining);
}

/// A body that chatters (a third of its impacts of the step are used up) loses its spin: to take
/// the rattle of something small and fast for inelastic costs energy, to hold it would cost time.
void btCcdStep::calmDown(btCollisionObject* object)
{
    const btCcdBody body = btCcdBody::of(object);
    if (body.isNone() || object->isStaticOrKinematicObject() ||
        m_fates[body].m_impacts <= m_budget.m_impactsPerBody / kChatter)
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
    if (limit)
    {
        (void)countStuck(impact, impact.m_time < kFirstPart * m_timeStep);
    }
    if (limit && answer != btCcdAfterImpact::Hold && settle(impact))
    {
        return true;
    }
    if (limit || answer == btCcdAfterImpact::Hold)
    {
        yield(impact, remaining);
        return true;
    }
    return answer == btCcdAfterImpact::Continue || stoppedA || stoppedB;
}

/// Of the limits of the budget.
double btCcdStep::share(const btCcdImpact& impact) const
{
    return std::max(m_context.m_objects.of(impact.m_objectA).m_priority,
                    m_context.m_objects.of(impact.m_objectB).m_priority);
}

bool btCcdStep::isSpent(double share) const
{
    const auto seconds = [this]
    { return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_begin).count(); };
    return m_impacts > share * m_budget.m_impactsPerStep ||
           (m_budget.m_seconds > 0.0 && seconds() > share * m_budget.m_seconds);
}

/// What the solver could not part in so many impacts goes on without spin (a multibody: without the
/// motion of its joints, too) and without approach: for convex bodies that ends it, and costs no
/// time. False if it was in vain.
bool btCcdStep::settle(const btCcdImpact& impact)
{
    const double times = share(impact);
    if (isSpent(times))
    {
        return false;
    }
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        const Fate& fate = m_fates[body];
        if (fate.m_yield || fate.m_impacts > times * m_budget.m_impactsPerBody + kSettlings ||
            fate.m_atInstant > times * m_budget.m_impactsPerInstant + kSettlings)
        {
            return false;
        }
    }
    part(impact, btScalar(0));
    return true;
}

/// Takes the spin and the approach from the two bodies, and of how they slide along each other the
/// part `drag`.
void btCcdStep::part(const btCcdImpact& impact, btScalar drag)
{
    btVector3 relative(0, 0, 0);
    btScalar mobility = 0;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        const btScalar side = object == impact.m_objectA ? btScalar(1) : btScalar(-1);
        const btVector3& point = object == impact.m_objectA ? impact.m_pointA : impact.m_pointB;
        const btVector3 velocity = !body.isFree() && body.m_rigidBody != nullptr
                                       ? body.m_rigidBody->getVelocityInLocalPoint(
                                             point - object->getWorldTransform().getOrigin())
                                       : body.velocity();
        relative += side * velocity;
        mobility += body.mobility();
    }
    const btScalar approach = relative.dot(impact.m_normal);
    const btVector3 along = relative - approach * impact.m_normal;
    const btVector3 parted = std::max(approach, btScalar(0)) * impact.m_normal + drag * along;
    const btVector3 impulse = mobility > btScalar(0) ? parted / mobility : btVector3(0, 0, 0);
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btScalar side = object == impact.m_objectA ? btScalar(-1) : btScalar(1);
        const btCcdBody body = btCcdBody::of(object);
        body.slide(side * impulse);
        if (body.isFree())
        {
            ++m_counters.m_settled;
            tell(object, btCcdYield::Settled, impact);
        }
    }
}

/// Counts the impact for both bodies.
bool btCcdStep::meetsLimit(const btCcdImpact& impact)
{
    const double times = share(impact);
    bool meets = isSpent(times);
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btCcdBody body = btCcdBody::of(object);
        if (!body.isFree())
        {
            continue;
        }
        Fate& fate = m_fates[body];
        if (impact.m_time > fate.m_instant + kInstant * m_timeStep)
        {
            fate.m_instant = impact.m_time;
            fate.m_atInstant = 0;
        }
        ++fate.m_impacts;
        ++fate.m_atInstant;
        meets = meets || fate.m_impacts > times * m_budget.m_impactsPerBody ||
                fate.m_atInstant > times * m_budget.m_impactsPerInstant;
    }
    m_counters.m_eventLimits += meets ? 1 : 0;
    return meets;
}

/// The next of the ways in which bodies give way: they are held; one that is held already is
/// carried along by what presses on it; one that is carried into something else that cannot give
/// way is squeezed. Every body takes every one of these once, or a few times, so this ends.
void btCcdStep::yield(const btCcdImpact& impact, btScalar remaining)
{
    const bool heldA = hold(impact, impact.m_objectA, remaining);
    const bool heldB = hold(impact, impact.m_objectB, remaining);
    if (heldA || heldB)
    {
        return;
    }
    for (const int side : {0, 1})
    {
        const btCollisionObject* carrier = carrierIn(impact, 1 - side);
        if (carrier != nullptr && carry(impact, side, *carrier, remaining))
        {
            return;
        }
    }
    squeeze(impact, impact.m_objectA);
    squeeze(impact, impact.m_objectB);
}

/// What moves this side of the impact, and nothing stops: a kinematic object.
const btCollisionObject* btCcdStep::carrierIn(const btCcdImpact& impact, int side)
{
    btCollisionObject* object = side == 0 ? impact.m_objectA : impact.m_objectB;
    const btCcdBody body = btCcdBody::of(object);
    if (body.isFree())
    {
        return m_fates[body].m_carrier;
    }
    return object->isKinematicObject() ? object : nullptr;
}

/// Where the carrier takes the body until the step ends, and a little away from it. False if the
/// body is beyond that.
bool btCcdStep::carry(const btCcdImpact& impact,
                      int side,
                      const btCollisionObject& carrier,
                      btScalar remaining)
{
    btCollisionObject* object = side == 0 ? impact.m_objectA : impact.m_objectB;
    const btCcdBody body = btCcdBody::of(object);
    const btCcdObjectMotion* motion = m_stepper.motionOf(carrier);
    Fate& fate = m_fates[body];
    const bool canMove = body.isFree() && body.mobility() > btScalar(0);
    if (!canMove || motion == nullptr || fate.m_yield == btCcdYield::Squeezed ||
        (fate.m_carrier != nullptr && fate.m_carrier != &carrier) || fate.m_carries >= kCarries ||
        !(remaining > btScalar(0)))
    {
        return false;
    }
    const btTransform from = btCcdToBullet(btCcdShapePoseAt(*motion, 0.0));
    const btTransform turn = btCcdToBullet(btCcdShapePoseAt(*motion, 1.0)) * from.inverse();
    const btVector3 place = body.m_rigidBody != nullptr
                                ? body.m_rigidBody->getCenterOfMassTransform().getOrigin()
                                : body.m_multiBody->getBasePos();
    const btQuaternion rotation = turn.getRotation();
    const btScalar angle = rotation.getAngleShortestPath();
    const btScalar sign = rotation.w() < btScalar(0) ? btScalar(-1) : btScalar(1);
    const btVector3 angular =
        angle > SIMD_EPSILON ? sign * rotation.getAxis() * angle / remaining : btVector3(0, 0, 0);
    const btScalar lever = (place - from.getOrigin()).length();
    const btScalar offCircle = lever * (btScalar(1) - btCos(btScalar(0.5) * angle));
    const auto least = btScalar(kAway * m_stepper.tolerance());
    const btScalar away = btScalar(1 << std::min(fate.m_carries, kFarAway)) * (least + offCircle);
    const btVector3 out = side == 0 ? -impact.m_normal : impact.m_normal;
    const btVector3 along = (turn * place - place) / remaining;
    body.setVelocity(along, angular);
    fate.m_after.emplace(body);
    body.setVelocity(along + away * out / remaining, angular);
    if (fate.m_carries++ == 0)
    {
        ++m_counters.m_carried;
        tell(object, btCcdYield::Carried, impact);
    }
    fate.m_yield = btCcdYield::Carried;
    fate.m_own.emplace(body);
    fate.m_carrier = &carrier;
    return true;
}

/// What presses on the body from two sides goes on; Bullet parts them as it can.
void btCcdStep::squeeze(const btCcdImpact& impact, btCollisionObject* object)
{
    const btCcdBody body = btCcdBody::of(object);
    if (!body.isFree() || m_fates[body].m_yield == btCcdYield::Squeezed)
    {
        return;
    }
    Fate& fate = m_fates[body];
    fate.m_yield = btCcdYield::Squeezed;
    fate.m_carrier = nullptr;
    btCcdStop(body);
    m_stepper.squeezed(*object);
    ++m_counters.m_squeezed;
    tell(object, btCcdYield::Squeezed, impact);
}

void btCcdStep::tell(const btCollisionObject* object, btCcdYield how, const btCcdImpact& impact)
{
    if (m_listener != nullptr)
    {
        m_listener->onYield(*object, how, impact);
    }
}

/// An answer to others does not move what has been stopped, and what is held gathers no speed.
void btCcdStep::keepStopped(const btCcdBody& body)
{
    const auto known = m_fates.find(body);
    if (known != m_fates.end() && isStopped(known->second))
    {
        btCcdStop(body);
    }
    keepCarried(body);
}

/// Nor does it throw what is carried.
void btCcdStep::keepCarried(const btCcdBody& body)
{
    const auto known = m_fates.find(body);
    if (known != m_fates.end() && known->second.m_yield == btCcdYield::Carried)
    {
        known->second.m_own->restore();
    }
}

void btCcdStep::solve(const std::vector<btCcdImpact>& impacts, btCcdAnswer answer)
{
    if (impacts.empty())
    {
        return;
    }
    ++m_counters.m_subSteps;
    for (btCollisionObject* object : m_solver.solve(impacts, answer))
    {
        keepStopped(btCcdBody::of(object));
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

/// False if the body is stopped already, or cannot be.
bool btCcdStep::hold(const btCcdImpact& impact, btCollisionObject* object, btScalar remaining)
{
    const btCcdBody body = btCcdBody::of(object);
    if (!body.isFree() || m_fates[body].m_yield)
    {
        return false;
    }
    Fate& fate = m_fates[body];
    fate.m_yield = btCcdYield::Held;
    fate.m_own.emplace(body);
    if (body.isStill())
    {
        return false;
    }
    btCcdStop(body);
    countHold(body, remaining);
    tell(object, btCcdYield::Held, impact);
    return true;
}

/// Puts the body of an action where it was at the present time, unless it is held there (false).
bool btCcdStep::placeBack(btCollisionObject* object)
{
    const btCcdBody body = btCcdBody::of(object);
    if (!body.isFree() || isStopped(m_fates[body]))
    {
        return false;
    }
    if (btMultiBody* multiBody = body.m_multiBody)
    {
        const btCcdMultiBodyMotion* motion = body.isStill() || !btCcdIsStepped(*multiBody)
                                                 ? nullptr
                                                 : m_stepper.multiBodyMotionOf(*object);
        if (motion != nullptr)
        {
            btCcdPlaceAtStart(*multiBody, *motion);
        }
        return motion != nullptr;
    }
    const btCcdObjectMotion* motion = m_stepper.motionOf(*object);
    if (motion != nullptr)
    {
        body.m_rigidBody->setCenterOfMassTransform(btCcdToBullet(btCcdShapePoseAt(*motion, 0.0)));
    }
    return motion != nullptr;
}

/// It stays where it has been placed until the step ends.
void btCcdStep::holdBack(btCollisionObject* object, btScalar remaining)
{
    const btCcdBody body = btCcdBody::of(object);
    if (!body.isFree() || isStopped(m_fates[body]))
    {
        return;
    }
    m_fates[body].m_yield = btCcdYield::Held;
    const bool moved =
        body.m_multiBody == nullptr || (!body.isStill() && btCcdIsStepped(*body.m_multiBody));
    if (moved)
    {
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
    ++m_impacts;
    if (m_lastImpacts.size() < kMostSeen)
    {
        m_lastImpacts.push_back(
            {impact, impact.m_objectA->getWorldTransform(), impact.m_objectB->getWorldTransform()});
    }
}
