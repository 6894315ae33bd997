#include "grasp/sim/hand_simulation.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "grasp/sim/hand_multi_body.h"
#include "grasp/sim/hand_pairs.h"

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kRevoluteSpeed = 1.0;   // [rad/s]
constexpr double kPrismaticSpeed = 0.1;  // [m/s]
// A step is one time-of-impact query if nothing is hit. Queries bound the curvature of the motion
// over the whole step, so a few steps are faster than one; more than that gain nothing.
constexpr double kLongestStep = 0.2;  // [s]
// Surfaces closer than this intersect, for all that double precision can tell [m].
constexpr double kTouching = 1e-12;

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

/// The joints that move as one: a closing joint and its mimics.
struct Drive
{
    double speed = 0.0;     ///< of the closing joint, signed; 0: this joint drives nothing
    double timeLeft = 0.0;  ///< until its limit [s]
    bool running = false;
};

std::size_t at(std::int32_t index)
{
    return static_cast<std::size_t>(index);
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
    [[nodiscard]] bool overlapsAtStart(const Eigen::Isometry3d& X_WH,
                                       const std::vector<double>& positions) const;
    void start(const std::vector<double>& positions, const std::vector<double>& closed);
    [[nodiscard]] double stepLength() const;
    void advance(double step, const std::vector<double>& closed);
    void setPosition(std::size_t link, double position);
    void stopDrive(std::size_t driver);
    void stopLink(std::int32_t link, double time, bool byObject);

    /// The joint that moves joint i: itself or the one that it mimics.
    [[nodiscard]] std::size_t driverOf(std::size_t i) const
    {
        const Joint& joint = m_hand.robot.tree.links[i].joint;
        return joint.mimicOf == kNone ? i : at(joint.mimicOf);
    }
    [[nodiscard]] bool isMovable(std::size_t i) const
    {
        return i > 0 && m_hand.robot.tree.links[i].joint.isMovable();
    }

    const HandModel& m_hand;
    const GraspObject& m_object;
    HandPairs m_handPairs;
    HandMultiBody m_multiBody;
    btCcdMeshShape m_objectShape;
    btCollisionObject m_objectCollider;
    BulletParts m_parts;
    DrivenWorld m_world;

    std::vector<Drive> m_drives;  // one entry a link; used where the link's joint is a driver
    std::vector<StopEvent> m_stops;
    double m_time = 0.0;  // when the current step began [s]
};

HandSimulation::World::World(const HandModel& handModel, const GraspObject& graspObject)
    : m_hand(handModel),
      m_object(graspObject),
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
    m_world.setCcdMaxEvents(2 * static_cast<int>(handModel.robot.tree.size()) + 16);
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
            m_world.drive(body, static_cast<int>(i) - 1, 0.0);
        }
    }
}

bool HandSimulation::World::overlapsAtStart(const Eigen::Isometry3d& X_WH,
                                            const std::vector<double>& positions) const
{
    const std::vector<Eigen::Isometry3d> X_WL = linkPoses(m_hand.robot.tree, X_WH, positions);
    const auto overlap = [](const SsvTree* a, const SsvTree* b, const Eigen::Isometry3d& X_BA)
    {
        return a != nullptr && b != nullptr &&
               treeDistance(*a, *b, X_BA, kTouching).distance < kTouching;
    };
    for (std::size_t i = 0; i < X_WL.size(); ++i)
    {
        if (overlap(m_hand.linkTrees[i], &m_object.tree, X_WL[i]))
        {
            return true;
        }
    }
    return std::any_of(m_hand.selfPairs.begin(),
                       m_hand.selfPairs.end(),
                       [&](const auto& pair)
                       {
                           const auto [a, b] = pair;
                           return overlap(m_hand.linkTrees[at(a)],
                                          m_hand.linkTrees[at(b)],
                                          X_WL[at(b)].inverse() * X_WL[at(a)]);
                       });
}

void HandSimulation::World::start(const std::vector<double>& positions,
                                  const std::vector<double>& closed)
{
    const KinematicTree& tree = m_hand.robot.tree;
    m_stops.clear();
    m_time = 0.0;
    m_drives.assign(tree.size(), Drive{});
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        const int direction = m_hand.closingDirections[i];
        if (!joint.isMovable() || joint.mimicOf != kNone || direction == 0)
        {
            continue;
        }
        const double speed = joint.type == JointType::Revolute ? kRevoluteSpeed : kPrismaticSpeed;
        Drive& drive = m_drives[i];
        drive.speed = direction * speed;
        drive.timeLeft = (closed[i] - positions[i]) / drive.speed;
        drive.running = drive.timeLeft > 0.0;
    }
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Drive& drive = m_drives[driverOf(i)];
        if (isMovable(i) && drive.running)
        {
            const double ratio = driverOf(i) == i ? 1.0 : tree.links[i].joint.mimicMultiplier;
            m_world.drive(*m_multiBody.body, static_cast<int>(i) - 1, ratio * drive.speed);
        }
    }
}

double HandSimulation::World::stepLength() const
{
    double step = std::numeric_limits<double>::infinity();
    for (const Drive& drive : m_drives)
    {
        if (drive.running)
        {
            step = std::min({step, drive.timeLeft, kLongestStep});
        }
    }
    return std::isfinite(step) ? step : 0.0;
}

void HandSimulation::World::advance(double step, const std::vector<double>& closed)
{
    m_world.stepSimulation(step, 0);
    m_time += step;
    for (std::size_t driver = 0; driver < m_drives.size(); ++driver)
    {
        Drive& drive = m_drives[driver];
        if (!drive.running)
        {
            continue;
        }
        drive.timeLeft -= step;
        if (drive.timeLeft > 0.0)
        {
            continue;
        }
        stopDrive(driver);
        // Within rounding of where they are.
        for (std::size_t i = 1; i < closed.size(); ++i)
        {
            if (isMovable(i) && driverOf(i) == driver)
            {
                setPosition(i, closed[i]);
            }
        }
    }
}

void HandSimulation::World::stopDrive(std::size_t driver)
{
    m_drives[driver].running = false;
    for (std::size_t i = 1; i < m_drives.size(); ++i)
    {
        if (isMovable(i) && driverOf(i) == driver)
        {
            m_world.drive(*m_multiBody.body, static_cast<int>(i) - 1, 0.0);
        }
    }
}

btCcdAfterImpact HandSimulation::World::onImpact(const btCcdImpact& impact)
{
    const std::int32_t linkA = HandPairs::linkOf(impact.m_objectA);
    const std::int32_t linkB = HandPairs::linkOf(impact.m_objectB);
    const double time = m_time + impact.m_time;
    const bool byObject = linkA == kNone || linkB == kNone;
    for (const std::int32_t link : {linkA, linkB})
    {
        if (link != kNone)
        {
            stopLink(link, time, byObject);
        }
    }
    return btCcdAfterImpact::Continue;
}

void HandSimulation::World::stopLink(std::int32_t link, double time, bool byObject)
{
    // A link that another contact at this very time has stopped is in contact all the same.
    bool stopped = !m_stops.empty() && m_stops.back().time == time;
    for (std::int32_t i = link; i > 0; i = m_hand.robot.tree.links[at(i)].parent)
    {
        const std::size_t driver = driverOf(at(i));
        if (isMovable(at(i)) && m_drives[driver].running)
        {
            stopDrive(driver);
            stopped = true;
        }
    }
    const bool known = std::any_of(
        m_stops.begin(), m_stops.end(), [&](const StopEvent& event) { return event.link == link; });
    if (stopped && !known)
    {
        m_stops.push_back({.link = link, .time = time, .byObject = byObject});
    }
}

ClosingResult HandSimulation::World::close(const Eigen::Isometry3d& X_WH,
                                           const std::vector<double>& positions,
                                           const ClosingOptions& options)
{
    const KinematicTree& tree = m_hand.robot.tree;
    require(positions.size() == tree.size(),
            "closing: positions: one entry a link is needed, as in the hand's preshapes");
    require(std::all_of(positions.begin(),
                        positions.end(),
                        [](double position) { return std::isfinite(position); }) &&
                X_WH.matrix().allFinite(),
            "closing: a position or the pose of the hand is NaN or infinite");
    require(options.tolerance > 0.0, "closing: the tolerance must be positive");

    ClosingResult result;
    result.positions = positions;
    applyMimics(tree, result.positions);
    if (overlapsAtStart(X_WH, result.positions))
    {
        result.status = ToiStatus::Overlapping;
        return result;
    }
    const std::vector<double> closed = closedPositions(m_hand, result.positions);
    setTolerance(options.tolerance);
    m_world.resetCcdCounters();
    place(X_WH, result.positions);
    start(result.positions, closed);
    const btCcdCounters& counters = m_world.getCcdCounters();
    const auto gaveUp = [&] { return counters.m_iterationLimits + counters.m_eventLimits > 0; };
    for (double step = stepLength(); step > 0.0 && !gaveUp(); step = stepLength())
    {
        advance(step, closed);
        ++result.steps;
    }

    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        if (isMovable(i))
        {
            result.positions[i] = m_multiBody.body->getJointPos(static_cast<int>(i) - 1);
        }
    }
    result.stops = m_stops;
    result.status = m_stops.empty() ? ToiStatus::Separated : ToiStatus::Hit;
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
