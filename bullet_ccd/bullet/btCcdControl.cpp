#include "bullet_ccd/bullet/btCcdControl.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdContext.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdDebugDraw.h"
#include "bullet_ccd/bullet/motion/btCcdStopLink.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btIDebugDraw.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace
{
/// After so many impacts of one pair in a step, contact is no longer taken for a bounce.
constexpr int kBounces = 2;
constexpr int kMostPieces = 100;
/// A body chatters after this part of its impacts of a step; what is left of its spin then.
constexpr int kChatter = 3;
constexpr btScalar kCalm = btScalar(0.5);
/// How often a body is settled beyond its limit of impacts before it is held.
constexpr int kSettlings = 4;

bool isStill(const btMultiBody& body)
{
    bool still =
        body.getBaseVel() == btVector3(0, 0, 0) && body.getBaseOmega() == btVector3(0, 0, 0);
    for (int i = 0; i < body.getNumDofs(); ++i)
    {
        still = still && body.getVelocityVector()[6 + i] == btScalar(0);
    }
    return still;
}

/// `spin` shortened so that no part of the step can run into the integrator's limit, which counts
/// per call: a step in two parts would otherwise turn further than the whole.
btVector3 limitedSpin(const btVector3& spin, btScalar timeStep)
{
    const btScalar limit = ANGULAR_MOTION_THRESHOLD;
    const btScalar angle = spin.length() * timeStep;
    return angle > limit ? btVector3(spin * (limit * btScalar(0.999999) / angle)) : spin;
}

const btCollisionObject* firstCollider(const btMultiBody& body)
{
    const btCollisionObject* collider = body.getBaseCollider();
    for (int i = 0; i < body.getNumLinks() && collider == nullptr; ++i)
    {
        collider = body.getLink(i).m_collider;
    }
    return collider;
}

/// Visits what may turn about any axis: a rigid body (for null), the base and spherical joints of a
/// multibody, by link (-1: the base).
template <typename Visit>
void forSpins(const btMultiBody* body, const Visit& visit)
{
    visit(-1);
    for (int i = 0; body != nullptr && i < body->getNumLinks(); ++i)
    {
        if (body->getLink(i).m_jointType == btMultibodyLink::eSpherical)
        {
            visit(i);
        }
    }
}

/// Of the joints that are not moved by the user.
template <typename Change>
void forJointRates(btMultiBody& body, const Change& change)
{
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        for (int dof = 0; dof < body.getLink(i).m_dofCount && !body.isLinkKinematic(i); ++dof)
        {
            change(body.getJointVelMultiDof(i)[dof]);
        }
    }
}

btCcdContext& registeredContext(btDiscreteDynamicsWorld& world)
{
    if (auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(world.getDispatcher()))
    {
        btCcdCollisionAlgorithm::registerAlgorithm(dispatcher);
    }
    return btCcdContext::of(*world.getDispatcher());
}

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

btCcdControl::btCcdControl(btDiscreteDynamicsWorld& world)
    : m_world(world),
      m_multiBodyWorld(dynamic_cast<btMultiBodyDynamicsWorld*>(&world)),
      m_context(registeredContext(world)),
      m_stepper(world),
      m_solver(world)
{
    m_stepper.prepare();
}

btCcdControl::~btCcdControl() = default;

void btCcdControl::setCcdTolerance(double tolerance)
{
    if (!(tolerance > 0.0) || !std::isfinite(tolerance))
    {
        throw std::invalid_argument(
            "setCcdTolerance: the tolerance must be positive and finite; "
            "a thousandth of the smallest object is a good choice");
    }
    m_context.m_tolerance = tolerance;
}

double btCcdControl::getCcdTolerance() const
{
    return m_context.m_tolerance;
}

void btCcdControl::setCcdEnabled(const btCollisionObject* object, bool enabled)
{
    m_stepper.setEnabled(object, enabled);
}

bool btCcdControl::isCcdEnabled(const btCollisionObject* object) const
{
    return m_stepper.isEnabled(object);
}

void btCcdControl::stopLinkOnFirstContact(btMultiBody* body, int link)
{
    m_stopLinks.insert({body, link});
}

double btCcdControl::getCcdLostTime(const btCollisionObject* object) const
{
    const auto found = m_lostTimes.find(bodyOf(const_cast<btCollisionObject*>(object)));
    return found != m_lostTimes.end() ? found->second : 0.0;
}

void btCcdControl::resetCcdCounters()
{
    m_counters = {};
    m_lostTimes.clear();
}

void btCcdControl::forgetCcdShape(const btCollisionShape* shape)
{
    m_context.m_shapes.forget(shape);
    m_stepper.forgetShapes();
}

btCcdControl::Body btCcdControl::bodyOf(btCollisionObject* object)
{
    if (const auto* collider = btMultiBodyLinkCollider::upcast(object))
    {
        return {nullptr, collider->m_multiBody};
    }
    return {btRigidBody::upcast(object), nullptr};
}

bool btCcdControl::beginStep(btScalar timeStep)
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
    limitSpins(timeStep);
    // What turns no faster than Bullet turns it may meet less.
    if (m_limitedSpins.empty() || m_stepper.begin(timeStep, btCcdStepper::Motion::ToCome))
    {
        m_stepper.askAll();
    }
    return true;
}

void btCcdControl::integrateFromImpactToImpact(btScalar timeStep, const Integrate& integrate)
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
    m_spinning.clear();
    restoreSpins();
    countQueries();
}

/// An impact may leave a body spinning faster than Bullet's integrator turns it in one call.
void btCcdControl::integrateInPieces(btScalar time, const Integrate& integrate)
{
    if (!(time > btScalar(0)))
    {
        return;
    }
    btScalar fastest = 0;
    for (const Body& body : m_spinning)
    {
        forSpins(body.m_multiBody,
                 [&](int link) { fastest = std::max(fastest, spinOf(body, link).length()); });
    }
    const btScalar limit = ANGULAR_MOTION_THRESHOLD * btScalar(0.99);
    const int pieces = std::clamp(int(std::ceil(fastest * time / limit)), 1, kMostPieces);
    for (int i = 0; i < pieces; ++i)
    {
        integrate(time / btScalar(pieces));
    }
}

void btCcdControl::rollBackToImpacts(btScalar timeStep)
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

void btCcdControl::countQueries()
{
    const btCcdStepper::Counts& counts = m_stepper.counts();
    m_counters.m_queries += counts.m_queries;
    m_counters.m_overlaps += counts.m_overlaps;
    m_stepper.end();
}

/// It would stop bodies short of where the queries take them to be.
void btCcdControl::suspendStockClamping()
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

void btCcdControl::limitSpins(btScalar timeStep)
{
    const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
    for (int i = 0; i < bodies.size(); ++i)
    {
        limitSpins({bodies[i], nullptr}, bodies[i], timeStep);
    }
    for (int i = 0; m_multiBodyWorld != nullptr && i < m_multiBodyWorld->getNumMultibodies(); ++i)
    {
        btMultiBody* body = m_multiBodyWorld->getMultiBody(i);
        limitSpins({nullptr, body}, firstCollider(*body), timeStep);
    }
}

btVector3 btCcdControl::spinOf(const Body& body, int link)
{
    if (body.m_rigidBody != nullptr)
    {
        return body.m_rigidBody->getAngularVelocity();
    }
    if (link == kBase)
    {
        return body.m_multiBody->getBaseOmega();
    }
    const btScalar* velocity = body.m_multiBody->getJointVelMultiDof(link);
    return {velocity[0], velocity[1], velocity[2]};
}

void btCcdControl::setSpin(const Body& body, int link, const btVector3& spin)
{
    if (body.m_rigidBody != nullptr)
    {
        body.m_rigidBody->setAngularVelocity(spin);
    }
    else if (link == kBase)
    {
        body.m_multiBody->setBaseOmega(spin);
    }
    else
    {
        std::copy_n(&spin[0], 3, body.m_multiBody->getJointVelMultiDof(link));
    }
}

void btCcdControl::limitSpins(const Body& body,
                              const btCollisionObject* collider,
                              btScalar timeStep)
{
    if (collider == nullptr)
    {
        return;  // meets nothing
    }
    forSpins(body.m_multiBody,
             [&](int link)
             {
                 const btVector3 spin = spinOf(body, link);
                 const btVector3 limited = limitedSpin(spin, timeStep);
                 if (limited != spin)
                 {
                     m_limitedSpins.push_back({body, link, collider, spin, limited});
                     setSpin(body, link, limited);
                 }
             });
}

void btCcdControl::endStep()
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

void btCcdControl::releaseHeld()
{
    for (const Held& held : m_held)
    {
        if (btRigidBody* body = held.m_body.m_rigidBody)
        {
            body->setLinearVelocity(held.m_linear);
            body->setAngularVelocity(held.m_angular);
            continue;
        }
        btMultiBody& body = *held.m_body.m_multiBody;
        if (!body.isBaseKinematic())
        {
            body.setBaseVel(held.m_linear);
            body.setBaseOmega(held.m_angular);
        }
        for (int i = 0; i < body.getNumLinks(); ++i)
        {
            const btMultibodyLink& link = body.getLink(i);
            // A link that was stopped for good while its body was held stays stopped.
            for (int dof = 0; dof < link.m_dofCount && !body.isLinkKinematic(i); ++dof)
            {
                body.getJointVelMultiDof(i)[dof] =
                    held.m_joints[std::size_t(link.m_dofOffset + dof)];
            }
        }
    }
    m_held.clear();
}

void btCcdControl::restoreSpins()
{
    for (const Limited& spin : m_limitedSpins)
    {
        if (spinOf(spin.m_body, spin.m_link) == spin.m_limited)
        {
            setSpin(spin.m_body, spin.m_link, spin.m_wanted);
        }
    }
    m_limitedSpins.clear();
}

/// An impact sees all of a body's spin. From then on the step is integrated in pieces short enough.
void btCcdControl::spinFreely()
{
    for (const Limited& spin : m_limitedSpins)
    {
        m_spinning.insert(spin.m_body);
        m_stepper.changed(*spin.m_collider);
    }
    restoreSpins();
}

void btCcdControl::respond(const btCcdStepper::Event& event, btScalar remaining)
{
    spinFreely();
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
void btCcdControl::calmDown(btCollisionObject* object)
{
    const Body body = bodyOf(object);
    if (body.isNone() || object->isStaticOrKinematicObject() ||
        m_events[body] <= m_maxEvents / kChatter)
    {
        return;
    }
    if (btRigidBody* rigidBody = body.m_rigidBody)
    {
        rigidBody->setAngularVelocity(rigidBody->getAngularVelocity() * kCalm);
        return;
    }
    btMultiBody& multiBody = *body.m_multiBody;
    if (!multiBody.isBaseKinematic())
    {
        multiBody.setBaseOmega(multiBody.getBaseOmega() * kCalm);
    }
    forJointRates(multiBody, [](btScalar& rate) { rate *= kCalm; });
}

/// True if the listener, a stopped link or the limit of impacts has the last word.
bool btCcdControl::isDone(const btCcdImpact& impact, btScalar remaining)
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
bool btCcdControl::settle(const btCcdImpact& impact)
{
    btScalar approach = 0;
    btScalar mobility = 0;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const Body body = bodyOf(object);
        if (m_events[body] > m_maxEvents + kSettlings)
        {
            return false;
        }
        const btScalar side = object == impact.m_objectA ? btScalar(1) : btScalar(-1);
        approach += side * velocityOf(body).dot(impact.m_normal);
        mobility += mobilityOf(body);
    }
    const btScalar impulse =
        mobility > btScalar(0) ? std::max(approach, btScalar(0)) / mobility : btScalar(0);
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const btScalar side = object == impact.m_objectA ? btScalar(-1) : btScalar(1);
        slide(bodyOf(object), side * impulse * impact.m_normal);
    }
    return true;
}

/// Of the base.
btVector3 btCcdControl::velocityOf(const Body& body)
{
    return body.m_rigidBody != nullptr   ? body.m_rigidBody->getLinearVelocity()
           : body.m_multiBody != nullptr ? body.m_multiBody->getBaseVel()
                                         : btVector3(0, 0, 0);
}

/// One over the mass of what slides as one; zero for what does not.
btScalar btCcdControl::mobilityOf(const Body& body)
{
    if (body.m_multiBody == nullptr)
    {
        return body.m_rigidBody != nullptr ? body.m_rigidBody->getInvMass() : btScalar(0);
    }
    const btMultiBody& chain = *body.m_multiBody;
    if (chain.hasFixedBase() || chain.isBaseKinematic())
    {
        return 0;
    }
    btScalar mass = chain.getBaseMass();
    for (int i = 0; i < chain.getNumLinks(); ++i)
    {
        mass += chain.getLinkMass(i);
    }
    return btScalar(1) / mass;
}

/// Without any turn, at the velocity of its base after the impulse.
void btCcdControl::slide(const Body& body, const btVector3& impulse)
{
    const btVector3 zero(0, 0, 0);
    if (btRigidBody* rigidBody = body.m_rigidBody)
    {
        if (!rigidBody->isStaticOrKinematicObject())
        {
            rigidBody->applyCentralImpulse(impulse);
            rigidBody->setAngularVelocity(zero);
        }
        return;
    }
    if (btMultiBody* chain = body.m_multiBody)
    {
        chain->setBaseVel(chain->getBaseVel() + mobilityOf(body) * impulse);
        if (!chain->isBaseKinematic())
        {
            chain->setBaseOmega(zero);
        }
        forJointRates(*chain, [](btScalar& rate) { rate = 0; });
    }
}

bool btCcdControl::meetsLimit(const btCcdImpact& impact)
{
    bool meets = false;
    for (btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        const Body body = bodyOf(object);
        const bool moves = !body.isNone() && !object->isStaticOrKinematicObject();
        meets = meets || (moves && ++m_events[body] > m_maxEvents);
    }
    m_counters.m_eventLimits += meets ? 1 : 0;
    return meets;
}

void btCcdControl::solve(const std::vector<btCcdImpact>& impacts, bool bouncing)
{
    if (impacts.empty())
    {
        return;
    }
    ++m_counters.m_subSteps;
    for (btCollisionObject* object : m_solver.solve(impacts, bouncing))
    {
        m_spinning.insert(bodyOf(object));
        m_stepper.changed(*object);
    }
}

bool btCcdControl::stopWatchedLink(const btCollisionObject* object, int link)
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

void btCcdControl::hold(btCollisionObject* object, btScalar remaining)
{
    const Body body = bodyOf(object);
    const btVector3 zero(0, 0, 0);
    if (btMultiBody* multiBody = body.m_multiBody)
    {
        if (isStill(*multiBody))
        {
            return;  // stands, or is held already
        }
        const btScalar* joints = multiBody->getVelocityVector() + 6;
        m_held.push_back({body,
                          multiBody->getBaseVel(),
                          multiBody->getBaseOmega(),
                          std::vector<btScalar>(joints, joints + multiBody->getNumDofs())});
        multiBody->setBaseVel(zero);
        multiBody->setBaseOmega(zero);
        for (int i = 0; i < multiBody->getNumLinks(); ++i)
        {
            std::fill_n(
                multiBody->getJointVelMultiDof(i), multiBody->getLink(i).m_dofCount, btScalar(0));
        }
        countHold(body, remaining);
        return;
    }
    btRigidBody* rigidBody = body.m_rigidBody;
    if (rigidBody != nullptr && !rigidBody->isStaticOrKinematicObject() &&
        (rigidBody->getLinearVelocity() != zero || rigidBody->getAngularVelocity() != zero))
    {
        m_held.push_back(
            {body, rigidBody->getLinearVelocity(), rigidBody->getAngularVelocity(), {}});
        rigidBody->setLinearVelocity(zero);
        rigidBody->setAngularVelocity(zero);
        countHold(body, remaining);
    }
}

/// Undoes the last `remaining` seconds of the body's motion; once a step.
void btCcdControl::placeBack(btCollisionObject* object, btScalar remaining)
{
    const Body body = bodyOf(object);
    if (body.isNone() || ++m_events[body] > 1)
    {
        return;
    }
    if (btMultiBody* multiBody = body.m_multiBody)
    {
        if (isStill(*multiBody) || !btCcdIsStepped(*multiBody))
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

void btCcdControl::countHold(const Body& body, btScalar remaining)
{
    ++m_counters.m_clamps;
    m_counters.m_lostTime += double(remaining);
    m_lostTimes[body] += double(remaining);
}

void btCcdControl::drawCcd(btIDebugDraw* drawer)
{
    if (drawer == nullptr || (drawer->getDebugMode() & btIDebugDraw::DBG_DrawWireframe) == 0)
    {
        return;
    }
    btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        const btCcdShapeModel* model = m_context.model(objects[i]->getCollisionShape());
        if (model == nullptr || !isCcdEnabled(objects[i]))
        {
            continue;
        }
        btCcdDrawHierarchy({*model, objects[i]->getWorldTransform()}, m_drawLevel, *drawer);
        btVector3 low;
        btVector3 high;
        if (m_stepper.sweptBox(*objects[i], low, high))
        {
            btCcdDrawSweptBox(low, high, *drawer);
        }
    }
    const auto isThere = [&](btCollisionObject* object)
    { return objects.findLinearSearch(object) < objects.size(); };
    for (const SeenImpact& seen : m_lastImpacts)
    {
        const btCcdImpact& impact = seen.m_impact;
        if (!isThere(impact.m_objectA) || !isThere(impact.m_objectB))
        {
            continue;  // removed since
        }
        const btCcdShapeModel* a = m_context.model(impact.m_objectA->getCollisionShape());
        const btCcdShapeModel* b = m_context.model(impact.m_objectB->getCollisionShape());
        if (a != nullptr && b != nullptr)
        {
            btCcdDrawImpact({*a, seen.m_poseA},
                            impact.m_pointA,
                            {*b, seen.m_poseB},
                            impact.m_pointB,
                            impact.m_normal,
                            *drawer);
        }
    }
}

void btCcdControl::note(const btCcdImpact& impact)
{
    ++m_counters.m_impacts;
    m_lastImpacts.push_back(
        {impact, impact.m_objectA->getWorldTransform(), impact.m_objectB->getWorldTransform()});
}
