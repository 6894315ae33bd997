#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/soak/bullet_soaks.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/hand/hand_model.h"
#include "grasp/sim/hand_multi_body.h"
#include "grasp/sim/hand_pairs.h"
#include "tools/support/progress_line.h"

#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using grasp::HandModel;

constexpr double kDensityInHand = 500.0;  // of the objects that are held [kg/m^3]
constexpr double kClosingTime = 0.5;      // [s]
constexpr double kHoldingTime = 0.1;      // [s]
constexpr double kOpeningTime = 0.4;      // [s]
constexpr double kTorque = 0.3;           // of each joint at most [N m], or [N]
constexpr double kLead = 0.05;            // of the target before the joint, at most [rad] or [m]
constexpr double kClearance = 2e-3;       // of the object from the open hand [m]
constexpr std::size_t kOrientations = 6;
constexpr double kNearestPlace = -0.03;  // along the approach, from the grasp frame [m]
constexpr double kFarthestPlace = 0.4;   // from the grasp frame [m]
constexpr int kSolverIterations = 100;

/// The one for grasps with all fingers if the hand has it, else the first.
const grasp::Preshape& preshapeOf(const HandModel& hand)
{
    const auto found = std::ranges::find(hand.preshapes, "power", &grasp::Preshape::name);
    return found == hand.preshapes.end() ? hand.preshapes.front() : *found;
}
/// One hand and one object, no gravity.
class HandScene
{
public:
    /// Refers to both.
    HandScene(const HandModel& hand, const HouseholdObject& object, const HandSoak& soak);
    ~HandScene();
    HandScene(const HandScene&) = delete;
    HandScene& operator=(const HandScene&) = delete;

    /// Puts the object before the hand, closes, holds, opens. True if the hand held something.
    bool close(Random& random);

    [[nodiscard]] const AuditResult& seen() const { return m_seen; }
    [[nodiscard]] const btCcdControl& control() { return m_world.ccd(); }
    [[nodiscard]] const std::vector<std::string>& names() const { return m_names; }
    [[nodiscard]] WorldAudit::Busiest busiest() const { return m_audit.busiestPair(); }

private:
    const HandModel& m_hand;
    double m_timeStep;
    grasp::HandPairs m_pairs;
    grasp::HandMultiBody m_body;
    std::vector<std::shared_ptr<const AuditMesh>> m_linkMeshes;  // one a link, null without
    examples::World m_world{examples::Engine::Ccd};
    WorldAudit m_audit;
    std::vector<std::string> m_names;              // by number in the audit
    std::vector<btMultiBodyJointMotor*> m_motors;  // one a link, null if fixed
    std::vector<std::unique_ptr<btMultiBodyConstraint>> m_constraints;
    std::vector<double> m_open;
    std::vector<double> m_closed;
    const HouseholdObject& m_kind;
    btRigidBody* m_object = nullptr;
    AuditResult m_seen;

    void addLinks();
    void addMotors();
    void place(Random& random);
    [[nodiscard]] bool isClear(const Eigen::Isometry3d& X_WO) const;
    void move(double seconds, double from, double to);
    [[nodiscard]] bool touches();
};

HandScene::HandScene(const HandModel& hand, const HouseholdObject& object, const HandSoak& soak)
    : m_hand(hand),
      m_timeStep(soak.timeStep),
      m_pairs(hand),
      m_body(grasp::makeHandMultiBody(hand)),
      m_audit(*m_world, {.longestMove = soak.longestMove, .mostSamples = soak.mostSamples}),
      m_open(preshapeOf(hand).positions),
      m_closed(grasp::closedPositions(hand, m_open)),
      m_kind(object)
{
    m_world->setGravity(btVector3(0, 0, 0));
    m_world->getSolverInfo().m_numIterations = kSolverIterations;
    m_world->getPairCache()->setOverlapFilterCallback(&m_pairs);
    m_world.ccd().setCcdImpactListener(&m_audit);
    addLinks();
    addMotors();
    m_object = m_world.add(std::make_unique<btCcdMeshShape>(object.tree), object.mass);
    m_object->setActivationState(DISABLE_DEACTIVATION);
    m_names.push_back(object.name);
    m_audit.add(m_object, object.audit);
}

HandScene::~HandScene()
{
    for (const auto& constraint : m_constraints)
    {
        m_world->removeMultiBodyConstraint(constraint.get());
    }
    for (const auto& collider : m_body.colliders)
    {
        if (collider != nullptr)
        {
            m_world->removeCollisionObject(collider.get());
        }
    }
    m_world->removeMultiBody(m_body.body.get());
}

void HandScene::addLinks()
{
    btMultiBody& body = *m_body.body;
    body.setBaseWorldTransform(btCcdToBullet(m_body.X_LI.front()));
    body.setCanSleep(false);
    for (std::size_t i = 1; i < m_hand.robot.tree.size(); ++i)
    {
        if (m_hand.robot.tree.links[i].joint.isMovable())
        {
            body.setJointPos(static_cast<int>(i) - 1, btScalar(m_open[i]));
        }
    }
    m_world->addMultiBody(&body);
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);

    std::vector<std::pair<std::int32_t, std::int32_t>> links;  // index, number in the audit
    for (std::size_t i = 0; i < m_hand.robot.tree.size(); ++i)
    {
        m_linkMeshes.emplace_back();
        if (m_body.colliders[i] == nullptr)
        {
            continue;
        }
        m_world->addCollisionObject(m_body.colliders[i].get(),
                                    btBroadphaseProxy::DefaultFilter,
                                    btBroadphaseProxy::AllFilter);
        m_linkMeshes[i] = std::make_shared<const AuditMesh>(m_hand.linkTrees[i]->mesh());
        const std::int32_t number =
            m_audit.add(m_body.colliders[i].get(), m_linkMeshes[i], m_body.X_LI[i].inverse());
        m_names.push_back(m_hand.robot.tree.links[i].name);
        for (const auto& [other, otherNumber] : links)
        {
            if (!m_pairs.mayMeet(other, static_cast<std::int32_t>(i)))
            {
                m_audit.ignore(otherNumber, number);
            }
        }
        links.emplace_back(static_cast<std::int32_t>(i), number);
    }
    m_audit.addMultiBody(&body);
}

void HandScene::addMotors()
{
    const auto add = [&](auto constraint)
    {
        m_world->addMultiBodyConstraint(constraint.get());
        m_constraints.push_back(std::move(constraint));
    };
    m_motors.resize(m_hand.robot.tree.size());
    for (std::size_t i = 1; i < m_motors.size(); ++i)
    {
        const Joint& joint = m_hand.robot.tree.links[i].joint;
        if (joint.isMovable())
        {
            const int link = static_cast<int>(i) - 1;
            auto motor = std::make_unique<btMultiBodyJointMotor>(
                m_body.body.get(), link, btScalar(0), btScalar(kTorque * m_timeStep));
            m_motors[i] = motor.get();
            add(std::move(motor));
            add(std::make_unique<btMultiBodyJointLimitConstraint>(
                m_body.body.get(), link, btScalar(joint.lower), btScalar(joint.upper)));
        }
    }
}

bool HandScene::isClear(const Eigen::Isometry3d& X_WO) const
{
    for (std::size_t i = 0; i < m_linkMeshes.size(); ++i)
    {
        if (m_linkMeshes[i] == nullptr)
        {
            continue;
        }
        const Eigen::Isometry3d X_WL =
            btCcdToEigen(m_body.colliders[i]->getWorldTransform()) * m_body.X_LI[i].inverse();
        // Not by auditPair(), which also measures how deep things are inside each other.
        const Eigen::Isometry3d X_OL = X_WO.inverse() * X_WL;
        const AuditMesh& link = *m_linkMeshes[i];
        const TrianglePair nearest =
            treeDistance(*m_hand.linkTrees[i], *m_kind.tree, X_OL, kClearance);
        if (nearest.distance <= 0.0 ||
            m_kind.audit->contains(X_OL * link.mesh().vertices.front()) ||
            link.contains(X_OL.inverse() * m_kind.audit->mesh().vertices.front()))
        {
            return false;
        }
    }
    return true;
}

void HandScene::place(Random& random)
{
    // As near to the palm as it goes in some of its orientations, and a little off.
    std::array<Eigen::Matrix3d, kOrientations> orientations;
    std::ranges::generate(orientations, [&] { return random.rotation(); });
    for (double z = kNearestPlace; z < kFarthestPlace; z += kClearance)
    {
        for (const Eigen::Matrix3d& orientation : orientations)
        {
            Eigen::Isometry3d X_GO = Eigen::Isometry3d::Identity();
            X_GO.linear() = orientation;
            X_GO.translation().z() = z;
            const Eigen::Isometry3d X_WO = m_hand.X_RG * X_GO;
            X_GO.translation().z() = z + kClearance;
            const Eigen::Isometry3d X_WFurther = m_hand.X_RG * X_GO;
            if (isClear(X_WO) && isClear(X_WFurther))
            {
                m_object->setWorldTransform(btCcdToBullet(X_WFurther));
                m_object->setInterpolationWorldTransform(btCcdToBullet(X_WFurther));
                m_object->setLinearVelocity(btVector3(0, 0, 0));
                m_object->setAngularVelocity(btVector3(0, 0, 0));
                m_object->clearForces();
                return;
            }
        }
    }
    throw std::runtime_error("no place for " + m_kind.name + " before the hand: try another seed");
}

bool HandScene::close(Random& random)
{
    place(random);
    m_seen.add(m_audit.start());
    move(kClosingTime, 0.0, 1.0);
    move(kHoldingTime, 1.0, 1.0);
    const bool held = touches();
    move(kOpeningTime, 1.0, 0.0);
    return held;
}

void HandScene::move(double seconds, double from, double to)
{
    const int steps = std::max(1, static_cast<int>(seconds / m_timeStep));
    for (int step = 1; step <= steps; ++step)
    {
        const double share = from + (to - from) * step / steps;
        for (std::size_t i = 0; i < m_motors.size(); ++i)
        {
            if (m_motors[i] == nullptr)
            {
                continue;
            }
            const double at = double(m_body.body->getJointPos(static_cast<int>(i) - 1));
            const double wanted = (1.0 - share) * m_open[i] + share * m_closed[i];
            const double rate = (to - from) * (m_closed[i] - m_open[i]) / seconds;
            m_motors[i]->setPositionTarget(btScalar(std::clamp(wanted, at - kLead, at + kLead)),
                                           btScalar(0.5));
            m_motors[i]->setVelocityTarget(btScalar(rate), btScalar(0.5));
        }
        m_seen.add(m_audit.step(m_timeStep));
    }
}

bool HandScene::touches()
{
    btDispatcher& dispatcher = *m_world->getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        if ((manifold.getBody0() == m_object || manifold.getBody1() == m_object) &&
            manifold.getNumContacts() > 0)
        {
            return true;
        }
    }
    return false;
}
SoakAnswer runHand(const HandModel& hand, const HandSoak& soak, std::uint64_t seed)
{
    const HouseholdObject object = makeHouseholdObject(seed - 1, seed, kDensityInHand);
    HandScene scene(hand, object, soak);
    Random random(7918 + seed);
    int held = 0;
    tools::ProgressLine progress(static_cast<std::size_t>(soak.closings), "closings");
    for (int closing = 0; closing < soak.closings; ++closing)
    {
        held += scene.close(random) ? 1 : 0;
        progress.show(static_cast<std::size_t>(closing) + 1, fmt::format(" on object {}", seed));
    }
    SoakAnswer answer{.status = 2 * held >= soak.closings ? ToiStatus::Hit : ToiStatus::Separated,
                      .judgement = judgementOf(scene.seen(), scene.names(), ""),
                      .counts = countsOf(scene.control(), scene.seen())};
    answer.counts["closings"] = soak.closings;
    answer.counts["held"] = held;
    printWorld(
        fmt::format(
            "seed {}: {} held {} times in {} closings", seed, object.name, held, soak.closings),
        scene.busiest(),
        scene.names(),
        answer.counts);
    return answer;
}
}  // namespace

SoakSubject handSoak(const HandSoak& soak)
{
    const auto hand = std::make_shared<const HandModel>(grasp::loadHand(soak.hand));
    return {
        .program = fmt::format("benchmarks/run soak bullet hand --hand {} --closings {} --dt {}",
                               soak.hand.string(),
                               soak.closings,
                               soak.timeStep),
        .families = {"hand"},
        .shares = {.leastHits = 50, .leastFree = 0, .enough = 1},
        .ask = [hand, soak](std::uint64_t seed) { return runHand(*hand, soak, seed); }};
}
}  // namespace bullet_ccd::benchmarks
