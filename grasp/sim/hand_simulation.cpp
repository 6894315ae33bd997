#include "grasp/sim/hand_simulation.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"
#include "bullet_ccd/math/check.h"
#include "grasp/closing/closing_drives.h"
#include "grasp/closing/closing_groups.h"
#include "grasp/sim/hand_multi_body.h"
#include "grasp/sim/hand_pairs.h"

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
// A step is one time-of-impact query if nothing is hit. Queries bound the curvature of the motion
// over the whole step, so a few steps are faster than one; more than that gain nothing.
constexpr double kLongestStep = 0.2;  // [s] at the usual speeds of joints

/// Links stop at their times of impact and move as they are driven: contacts would be found and
/// solved only to be overruled.
void makeNoContacts(btBroadphasePair& /*pair*/,
                    btCollisionDispatcher& /*dispatcher*/,
                    const btDispatcherInfo& /*info*/)
{
}

/// All that Bullet needs to make a world, as small as it comes.
struct BulletParts
{
    static btDefaultCollisionConstructionInfo sizes()
    {
        btDefaultCollisionConstructionInfo info;
        info.m_defaultMaxPersistentManifoldPoolSize = 1;
        info.m_defaultMaxCollisionAlgorithmPoolSize = 1;
        return info;
    }

    explicit BulletParts(int objects)
        : configuration(sizes()), dispatcher(&configuration), broadphase(objects)
    {
        dispatcher.setNearCallback(makeNoContacts);
    }

    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher;
    btCcdRegistration registration{dispatcher};
    btSimpleBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
};

/// A CCD world in which the hand's joints move at prescribed speeds: what a velocity servo that
/// never gives way would do. Bullet's forces act on everything else; on the joints they are
/// overruled before positions are integrated, so that coupled joints and limits are met exactly.
class DrivenWorld : public btCcdMultiBodyDynamicsWorld
{
public:
    using btCcdMultiBodyDynamicsWorld::btCcdMultiBodyDynamicsWorld;

    /// Speed of each of the body's links (revolute or prismatic; else ignored) from now on.
    void drive(btMultiBody& body, int link, btScalar speed)
    {
        m_speeds[{&body, link}] = speed;
        body.setJointVel(link, speed);
    }

    void integrateTransforms(btScalar timeStep) override
    {
        for (const auto& [joint, speed] : m_speeds)
        {
            joint.first->setJointVel(joint.second, speed);
        }
        btCcdMultiBodyDynamicsWorld::integrateTransforms(timeStep);
    }

private:
    std::map<std::pair<btMultiBody*, int>, btScalar> m_speeds;
};

/// Of a link, A or B of the impact, with the object.
GraspContact contactOf(const btCcdImpact& impact, std::int32_t link, bool isA)
{
    const Eigen::Vector3d normal = btCcdToEigen(impact.m_normal);
    const Eigen::Vector3d a = btCcdToEigen(impact.m_pointA);
    const Eigen::Vector3d b = btCcdToEigen(impact.m_pointB);
    return {.link = link,
            .point = isA ? b : a,
            .normal = isA ? normal : Eigen::Vector3d(-normal),
            .gap = (b - a).norm()};
}
}  // namespace

struct HandSimulation::World : btCcdImpactListener
{
    World(const HandModel& handModel, const GraspObject& graspObject);
    ~World() override;
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    ClosingResult close(const Eigen::Isometry3d& X_WH,
                        const std::vector<double>& positions,
                        const ClosingOptions& options);
    btCcdAfterImpact onImpact(const btCcdImpact& impact) override;

private:
    void setTolerance(double tolerance);
    void place(const Eigen::Isometry3d& X_WH, const std::vector<double>& positions);
    void step();
    void applySpeeds();
    void setPosition(std::size_t link, double position);

    [[nodiscard]] bool isMovable(std::size_t i) const
    {
        return i > 0 && m_hand.robot.tree.links[i].joint.isMovable();
    }

    const HandModel& m_hand;
    const GraspObject& m_object;
    ClosingGroups m_groups;
    HandPairs m_handPairs;
    HandMultiBody m_multiBody;
    btCcdMeshShape m_objectShape;
    btCollisionObject m_objectCollider;
    BulletParts m_parts;
    DrivenWorld m_world;

    ClosingDrives* m_drives = nullptr;     // while it closes
    double m_time = 0.0;                   // when the current step began [s]
    std::vector<GraspContact> m_contacts;  // of the links that the object has stopped
};

HandSimulation::World::World(const HandModel& handModel, const GraspObject& graspObject)
    : m_hand(handModel),
      m_object(graspObject),
      m_groups(closingGroups(handModel)),
      m_handPairs(handModel),
      m_multiBody(makeHandMultiBody(handModel)),
      m_objectShape(
          std::shared_ptr<const SsvTree>(std::shared_ptr<const SsvTree>{}, &graspObject.tree)),
      m_parts(static_cast<int>(handModel.robot.tree.size()) + 1),
      m_world(&m_parts.dispatcher, &m_parts.broadphase, &m_parts.solver, &m_parts.configuration)
{
    m_parts.broadphase.getOverlappingPairCache()->setOverlapFilterCallback(&m_handPairs);
    m_world.setGravity(btVector3(0, 0, 0));
    m_world.setCcdImpactListener(this);
    m_world.setCcdBudget(
        {.m_impactsPerBody = 2 * static_cast<int>(handModel.robot.tree.size()) + 16});
    m_multiBody.body->setCanSleep(false);
    m_world.addMultiBody(m_multiBody.body.get());
    for (const auto& collider : m_multiBody.colliders)
    {
        if (collider != nullptr)
        {
            m_world.addCollisionObject(
                collider.get(), btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
        }
    }
    m_objectCollider.setCollisionShape(&m_objectShape);
    m_world.addCollisionObject(
        &m_objectCollider, btBroadphaseProxy::StaticFilter, btBroadphaseProxy::AllFilter);
}

HandSimulation::World::~World()
{
    m_world.removeCollisionObject(&m_objectCollider);
    for (const auto& collider : m_multiBody.colliders)
    {
        if (collider != nullptr)
        {
            m_world.removeCollisionObject(collider.get());
        }
    }
    m_world.removeMultiBody(m_multiBody.body.get());
}

void HandSimulation::World::setPosition(std::size_t link, double position)
{
    m_multiBody.body->setJointPos(static_cast<int>(link) - 1, position);
}

/// Meshes are stopped within a sixteenth above the sum of their margins: at most `tolerance`.
void HandSimulation::World::setTolerance(double tolerance)
{
    const double margin = tolerance * (0.5 / (1.0 + 1.0 / 16.0));
    if (m_objectShape.getMargin() == margin)
    {
        return;
    }
    m_objectShape.setMargin(margin);
    for (const auto& mesh : m_multiBody.meshes)
    {
        if (mesh != nullptr)
        {
            mesh->setMargin(margin);
        }
    }
    m_world.setCcdTolerance(tolerance);
    m_world.forgetCcdShape(&m_objectShape);
}

void HandSimulation::World::place(const Eigen::Isometry3d& X_WH,
                                  const std::vector<double>& positions)
{
    btMultiBody& body = *m_multiBody.body;
    body.setBaseWorldTransform(btCcdToBullet(X_WH * m_multiBody.X_LI.front()));
    body.setBaseVel(btVector3(0, 0, 0));
    body.setBaseOmega(btVector3(0, 0, 0));
    for (std::size_t i = 1; i < positions.size(); ++i)
    {
        if (isMovable(i))
        {
            setPosition(i, positions[i]);
        }
    }
}

void HandSimulation::World::applySpeeds()
{
    for (std::size_t i = 1; i < m_drives->speeds().size(); ++i)
    {
        if (isMovable(i))
        {
            m_world.drive(*m_multiBody.body, static_cast<int>(i) - 1, m_drives->speeds()[i]);
        }
    }
}

void HandSimulation::World::step()
{
    const double end = std::min(m_drives->nextLimit(), m_time + kLongestStep / m_drives->pace());
    m_world.stepSimulation(end - m_time, 0);
    const std::vector<double> speeds = m_drives->speeds();
    if (m_drives->isRunning())
    {
        m_drives->advanceTo(end);
    }
    // What is left of a step in which all that moved has stopped does not count.
    m_time = m_drives->time();
    for (std::size_t i = 1; i < speeds.size(); ++i)
    {
        if (speeds[i] != 0.0 && m_drives->speeds()[i] == 0.0)
        {
            setPosition(i, m_drives->positions()[i]);  // at its limit, within rounding of there
        }
    }
    m_drives->beginNext();
    applySpeeds();
}

btCcdAfterImpact HandSimulation::World::onImpact(const btCcdImpact& impact)
{
    const std::int32_t linkA = HandPairs::linkOf(impact.m_objectA);
    const std::int32_t linkB = HandPairs::linkOf(impact.m_objectB);
    const double time = m_time + impact.m_time;
    const bool byObject = linkA == kNone || linkB == kNone;
    m_drives->advanceTo(time);
    for (const std::int32_t link : {linkA, linkB})
    {
        if (link != kNone && m_drives->stopLink(link, time, byObject) && byObject)
        {
            m_contacts.push_back(contactOf(impact, link, link == linkA));
        }
    }
    applySpeeds();
    return btCcdAfterImpact::Continue;
}

ClosingResult HandSimulation::World::close(const Eigen::Isometry3d& X_WH,
                                           const std::vector<double>& positions,
                                           const ClosingOptions& options)
{
    require(X_WH.matrix().allFinite(), "closing: the pose of the hand is NaN or infinite");
    require(options.tolerance > 0.0, "closing: the tolerance must be positive");
    ClosingDrives drives(
        m_hand, positions, closingTurns(m_hand, m_groups, options), closingSpeeds(m_hand, options));
    ClosingResult result;
    result.positions = drives.positions();
    if (handOverlaps(m_hand, m_object, X_WH, result.positions))
    {
        result.status = ToiStatus::Overlapping;
        return result;
    }
    setTolerance(options.tolerance);
    m_world.resetCcdCounters();
    place(X_WH, result.positions);
    m_drives = &drives;
    m_time = 0.0;
    m_contacts.clear();
    applySpeeds();
    const btCcdCounters& counters = m_world.getCcdCounters();
    const auto gaveUp = [&] { return counters.m_iterationLimits + counters.m_eventLimits > 0; };
    while (drives.isRunning() && !gaveUp())
    {
        step();
        ++result.steps;
    }
    m_drives = nullptr;

    for (std::size_t i = 1; i < result.positions.size(); ++i)
    {
        if (isMovable(i))
        {
            result.positions[i] = m_multiBody.body->getJointPos(static_cast<int>(i) - 1);
        }
    }
    result.stops = drives.stops();
    result.contacts = m_contacts;
    result.status = result.stops.empty() ? ToiStatus::Separated : ToiStatus::Hit;
    if (gaveUp())
    {
        result.status = ToiStatus::IterationLimit;
    }
    if (counters.m_overlaps > 0)
    {
        result.status = ToiStatus::Overlapping;
    }
    return result;
}

HandSimulation::HandSimulation(const HandModel& hand, const GraspObject& object)
    : m_world(std::make_unique<World>(hand, object))
{
}

HandSimulation::~HandSimulation() = default;
HandSimulation::HandSimulation(HandSimulation&&) noexcept = default;
HandSimulation& HandSimulation::operator=(HandSimulation&&) noexcept = default;

ClosingResult HandSimulation::close(const Eigen::Isometry3d& X_WH,
                                    const std::vector<double>& positions,
                                    const ClosingOptions& options)
{
    return m_world->close(X_WH, positions, options);
}

MakeCloseHand simulatedClosing()
{
    struct Engine
    {
        const HandModel* hand = nullptr;
        const GraspObject* object = nullptr;
        std::unique_ptr<HandSimulation> simulation;
    };
    return []() -> CloseHand
    {
        return [engine = std::make_shared<Engine>()](const HandModel& hand,
                                                     const GraspObject& object,
                                                     const Eigen::Isometry3d& X_WH,
                                                     const std::vector<double>& positions,
                                                     const ClosingOptions& options)
        {
            if (engine->hand != &hand || engine->object != &object)
            {
                engine->simulation = std::make_unique<HandSimulation>(hand, object);
                engine->hand = &hand;
                engine->object = &object;
            }
            return engine->simulation->close(X_WH, positions, options);
        };
    };
}
}  // namespace bullet_ccd::grasp
