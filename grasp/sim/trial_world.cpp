#include "grasp/sim/trial_world.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
// Groups of the broadphase: the table is for the object alone.
constexpr int kHandGroup = 1;
constexpr int kObjectGroup = 2;
constexpr int kTableGroup = 4;
constexpr int kSceneGroup = 8;

constexpr double kTableDepth = 0.05;  // half of it [m]
constexpr double kTableSizes = 2.0;   // half its width, over the diagonal of the object's box
constexpr double kRestBelow = 2e-5;   // [m]
/// Contacts that are farther from that do not press in this step, if bodies come no faster than
/// 0.03 m/s (at 120 steps per second); faster ones are stopped by the continuous world.
constexpr double kProcessed = 2.5e-4;  // [m]
constexpr double kRestingWay = 0.1;    // of the gap, by which contacts may be old; below kProcessed
constexpr double kSkinTime = 0.005;    // damping over stiffness of skins [s]
constexpr double kSkinDepth = 0.55;    // of the gap, that skins never give way by
constexpr double kHardest = 1e-2;      // room left over that depth, at the least
constexpr double kFastestJoint = 1e4;  // Bullet clamps speeds; none comes near this

btRigidBody::btRigidBodyConstructionInfo rigidInfo(double mass,
                                                   btCollisionShape& shape,
                                                   const btVector3& inertia,
                                                   const btTransform& pose)
{
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
    info.m_startWorldTransform = pose;
    info.m_linearDamping = info.m_angularDamping = 0.0;
    return info;
}

bool isLimited(const Joint& joint)
{
    return std::isfinite(joint.lower) && std::isfinite(joint.upper);
}
}  // namespace

TrialWorld::TrialWorld(const HandModel& hand,
                       const GraspObject& object,
                       const TrialBodies& bodies,
                       const Eigen::Isometry3d& X_WH,
                       const std::vector<double>& positions)
    : m_hand(hand),
      m_pairs(hand),
      m_multiBody(makeHandMultiBody(hand)),
      m_objectSize(bounds(object.tree.mesh()).diagonal().norm()),
      m_dispatcher(&m_configuration),
      m_world(&m_dispatcher, &m_broadphase, &m_solver, &m_configuration),
      m_drives(hand.robot.tree.size(), nullptr),
      m_friction(bodies.friction),
      m_spinDamping(bodies.spinDamping),
      m_margin(bodies.margin),
      m_stiffness(bodies.stiffness)
{
    require(
        std::isfinite(bodies.mass) && bodies.mass > 0.0,
        "trial: mass " + std::to_string(bodies.mass) + " kg of the object: give a positive one");
    require(std::isfinite(bodies.friction) && bodies.friction >= 0.0,
            "trial: friction " + std::to_string(bodies.friction) + ": give 0 or more");
    require(positions.size() == hand.robot.tree.size(),
            "trial: " + std::to_string(positions.size()) + " joint positions for " +
                std::to_string(hand.robot.tree.size()) + " links: give one per link");
    require(X_WH.matrix().allFinite(), "trial: the pose of the hand is NaN or infinite");
    m_dispatcher.setRestingWay(kRestingWay * 2.0 * m_margin);
    HoldingSolver::configure(m_world.getSolverInfo());
    // Surfaces rest a little below the sum of their margins. At the sum itself, where motion from
    // outside is stopped, rounding alone would make impacts of what rests.
    m_world.getSolverInfo().m_linearSlop = kRestBelow;
    m_world.setGravity(btVector3(0, 0, 0));
    m_world.setCcdTolerance(m_margin);
    m_broadphase.getOverlappingPairCache()->setOverlapFilterCallback(&m_pairs);

    btMultiBody& body = *m_multiBody.body;
    body.setCanSleep(false);
    body.setLinearDamping(0.0);
    body.setAngularDamping(0.0);
    body.setMaxCoordinateVelocity(kFastestJoint);
    body.setBaseWorldTransform(btCcdToBullet(X_WH * m_multiBody.X_LI.front()));
    const KinematicTree& tree = hand.robot.tree;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        if (tree.links[i].joint.isMovable())
        {
            body.setJointPos(static_cast<int>(i) - 1, positions[i]);
        }
    }
    m_world.addMultiBody(&body);
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        if (m_multiBody.colliders[i] != nullptr)
        {
            m_multiBody.meshes[i]->setMargin(m_margin);
            m_multiBody.colliders[i]->setFriction(std::sqrt(m_friction));
            m_multiBody.colliders[i]->setContactProcessingThreshold(kProcessed);
            m_world.addCollisionObject(m_multiBody.colliders[i].get(),
                                       kHandGroup,
                                       kHandGroup | kObjectGroup | kSceneGroup);
        }
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        const int link = static_cast<int>(i) - 1;
        if (!joint.isMovable())
        {
            continue;
        }
        if (joint.mimicOf != kNone)
        {
            m_constraints.push_back(std::make_unique<JointCoupling>(
                &body, link, joint.mimicOf - 1, joint.mimicMultiplier, joint.mimicOffset));
            continue;
        }
        auto drive = std::make_unique<JointDrive>(&body, link);
        m_drives[i] = drive.get();
        m_constraints.push_back(std::move(drive));
        if (isLimited(joint))
        {
            m_constraints.push_back(
                std::make_unique<JointStop>(&body, link, joint.lower, joint.upper));
        }
    }
    for (const auto& constraint : m_constraints)
    {
        constraint->finalizeMultiDof();
        m_world.addMultiBodyConstraint(constraint.get());
    }

    m_object = makeBody(object.tree,
                        Eigen::Isometry3d::Identity(),
                        bodies.mass,
                        bodies.centerOfMass.value_or(object.centerOfMass));
    m_world.addRigidBody(
        m_object.rigid.get(), kObjectGroup, kHandGroup | kObjectGroup | kTableGroup | kSceneGroup);
}

TrialWorld::Body TrialWorld::makeBody(const SsvTree& tree,
                                      const Eigen::Isometry3d& X_WB,
                                      double mass,
                                      const std::optional<Eigen::Vector3d>& centerOfMass) const
{
    Body body;
    body.X_OI = Eigen::Isometry3d::Identity();
    Eigen::Vector3d moments = Eigen::Vector3d::Zero();
    if (mass > 0.0)
    {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(
            inertiaAtMass(tree.mesh(), mass));
        body.X_OI.linear() = principal.eigenvectors();
        if (body.X_OI.linear().determinant() < 0.0)
        {
            body.X_OI.linear().col(2) *= -1.0;
        }
        body.X_OI.translation() = centerOfMass.value_or(massProperties(tree.mesh()).center);
        moments = principal.eigenvalues().cwiseMax(1e-15);
    }
    body.mesh = std::make_unique<btCcdMeshShape>(
        std::shared_ptr<const SsvTree>(&tree, [](const SsvTree*) {}));  // not owned
    body.mesh->setMargin(m_margin);
    body.shape = std::make_unique<btCompoundShape>(false, 1);
    body.shape->addChildShape(btCcdToBullet(body.X_OI.inverse()), body.mesh.get());
    body.rigid = std::make_unique<btRigidBody>(
        rigidInfo(mass, *body.shape, btCcdToBullet(moments), btCcdToBullet(X_WB * body.X_OI)));
    body.rigid->setFriction(std::sqrt(m_friction));
    body.rigid->setDamping(0.0, m_spinDamping);
    body.rigid->setContactProcessingThreshold(kProcessed);
    body.rigid->setActivationState(DISABLE_DEACTIVATION);
    return body;
}

void TrialWorld::addBody(const SsvTree& tree, const Eigen::Isometry3d& X_WB, double mass)
{
    require(std::isfinite(mass) && mass >= 0.0 && X_WB.matrix().allFinite(),
            "trial: a body needs a finite pose, and a mass of 0 or more");
    m_bodies.push_back(makeBody(tree, X_WB, mass, std::nullopt));
    m_world.addRigidBody(
        m_bodies.back().rigid.get(), kSceneGroup, kHandGroup | kObjectGroup | kSceneGroup);
}

TrialWorld::~TrialWorld()
{
    removeTable();
    m_world.removeRigidBody(m_object.rigid.get());
    for (const Body& body : m_bodies)
    {
        m_world.removeRigidBody(body.rigid.get());
    }
    for (const auto& constraint : m_constraints)
    {
        m_world.removeMultiBodyConstraint(constraint.get());
    }
    for (const auto& collider : m_multiBody.colliders)
    {
        if (collider != nullptr)
        {
            m_world.removeCollisionObject(collider.get());
        }
    }
    m_world.removeMultiBody(m_multiBody.body.get());
}

JointDrive* TrialWorld::driveOf(std::int32_t link) const
{
    JointDrive* drive = m_drives.at(static_cast<std::size_t>(link));
    require(drive != nullptr,
            "trial: the joint above link " + std::to_string(link) +
                " has no motor of its own: drive the joint that it follows");
    return drive;
}

void TrialWorld::drive(std::int32_t link, const DriveSettings& settings, double target)
{
    driveOf(link)->set(settings, target);
}

void TrialWorld::addTable(const Eigen::Vector3d& point, const Eigen::Vector3d& up)
{
    removeTable();
    const double half = kTableSizes * m_objectSize;
    m_tableShape = btCcdMeshShape::fromMesh(makeBox(Eigen::Vector3d(half, half, kTableDepth)));
    m_tableShape->setMargin(m_margin);
    Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();
    X_WT.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
    X_WT.translation() = point - up.normalized() * kTableDepth;
    m_table = std::make_unique<btRigidBody>(
        rigidInfo(0.0, *m_tableShape, btVector3(0, 0, 0), btCcdToBullet(X_WT)));
    m_table->setFriction(std::sqrt(m_friction));
    m_table->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    m_table->setActivationState(DISABLE_DEACTIVATION);
    m_world.addRigidBody(m_table.get(), kTableGroup, kObjectGroup);
}

void TrialWorld::moveTable(const Eigen::Vector3d& velocity)
{
    if (m_table != nullptr)
    {
        m_table->setLinearVelocity(btCcdToBullet(velocity));
    }
}

void TrialWorld::removeTable()
{
    if (m_table != nullptr)
    {
        m_world.removeRigidBody(m_table.get());
        m_table.reset();
    }
}

/// The stiffness is that of all points of the object, by the largest force of a point in the step
/// before: by the depths, skins that are deep would get hard, so be less deep, so get soft again.
void TrialWorld::hardenSkins()
{
    if (m_stiffness <= 0.0)
    {
        return;
    }
    double largest = 0.0;
    for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(i);
        // Those of other bodies on each other have no skins.
        const bool isOfObject = manifold.getBody0() == m_object.rigid.get() ||
                                manifold.getBody1() == m_object.rigid.get();
        for (int k = 0; isOfObject && k < manifold.getNumContacts(); ++k)
        {
            largest = std::max(largest, double(manifold.getContactPoint(k).getAppliedImpulse()));
        }
    }
    // The room that is left, of the depth, where stiffness (1 - room) depth / room^2 = force.
    const double load = largest / (m_timeStep * m_stiffness * kSkinDepth * 2.0 * m_margin);
    const double room = std::max(kHardest, 2.0 / (1.0 + std::sqrt(1.0 + 4.0 * load)));
    const double stiffness = m_stiffness / (room * room);
    m_object.rigid->setContactStiffnessAndDamping(stiffness, kSkinTime * stiffness);
    // Points that are there already have what they were made with.
    for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
    {
        btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(i);
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            btManifoldPoint& point = manifold.getContactPoint(k);
            if ((point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0)
            {
                point.m_combinedContactStiffness1 = stiffness;
                point.m_combinedContactDamping1 = kSkinTime * stiffness;
            }
        }
    }
}

void TrialWorld::step(double timeStep,
                      const Eigen::Vector3d& acceleration,
                      const Eigen::Vector3d& force,
                      const Eigen::Vector3d& moment)
{
    hardenSkins();
    m_timeStep = timeStep;
    for (JointDrive* drive : m_drives)
    {
        if (drive != nullptr)
        {
            drive->prepare(timeStep);
        }
    }
    if (m_table != nullptr)
    {
        btTransform pose = m_table->getWorldTransform();
        pose.setOrigin(pose.getOrigin() + timeStep * m_table->getLinearVelocity());
        m_table->setWorldTransform(pose);
        m_table->setInterpolationWorldTransform(pose);
    }
    for (const Body& body : m_bodies)
    {
        body.rigid->setGravity(btCcdToBullet(acceleration));
    }
    m_object.rigid->setGravity(btCcdToBullet(acceleration));
    m_object.rigid->applyCentralForce(btCcdToBullet(force));
    m_object.rigid->applyTorque(btCcdToBullet(moment));
    m_world.stepSimulation(timeStep, 0);
}

Eigen::Isometry3d TrialWorld::objectPose() const
{
    return btCcdToEigen(m_object.rigid->getWorldTransform()) * m_object.X_OI.inverse();
}

Eigen::Isometry3d TrialWorld::bodyPose(std::size_t body) const
{
    const Body& one = m_bodies.at(body);
    return btCcdToEigen(one.rigid->getWorldTransform()) * one.X_OI.inverse();
}

Eigen::Vector3d TrialWorld::objectCenter() const
{
    return btCcdToEigen(m_object.rigid->getWorldTransform().getOrigin());
}

Eigen::Vector3d TrialWorld::objectVelocity() const
{
    return btCcdToEigen(m_object.rigid->getLinearVelocity());
}

Eigen::Vector3d TrialWorld::objectSpin() const
{
    return btCcdToEigen(m_object.rigid->getAngularVelocity());
}

double TrialWorld::objectEnergy() const
{
    const btVector3& inverse = m_object.rigid->getInvInertiaDiagLocal();
    const btVector3 spin =
        m_object.rigid->getAngularVelocity() * m_object.rigid->getWorldTransform().getBasis();
    double energy =
        0.5 * m_object.rigid->getLinearVelocity().length2() / m_object.rigid->getInvMass();
    for (int k = 0; k < 3; ++k)
    {
        energy += inverse[k] > 0.0 ? 0.5 * spin[k] * spin[k] / inverse[k] : 0.0;
    }
    return energy;
}

std::vector<double> TrialWorld::positions() const
{
    const KinematicTree& tree = m_hand.robot.tree;
    std::vector<double> positions(tree.size(), 0.0);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        if (tree.links[i].joint.isMovable())
        {
            positions[i] = m_multiBody.body->getJointPos(static_cast<int>(i) - 1);
        }
    }
    return positions;
}

double TrialWorld::torque(std::int32_t link) const
{
    return driveOf(link)->torque();
}

HoldingForces TrialWorld::holdingForces() const
{
    HoldingForces forces;
    for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold =
            *const_cast<RestingDispatcher&>(m_dispatcher).getManifoldByIndexInternal(i);
        const bool isA = manifold.getBody0() == m_object.rigid.get();
        if (!isA && manifold.getBody1() != m_object.rigid.get())
        {
            continue;
        }
        if (HandPairs::linkOf(isA ? manifold.getBody1() : manifold.getBody0()) == kNone)
        {
            continue;
        }
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            const double force = manifold.getContactPoint(k).getAppliedImpulse() / m_timeStep;
            forces.largest = std::max(forces.largest, force);
            forces.sum += force;
            forces.points += force > 0.0 ? 1 : 0;
        }
    }
    return forces;
}
}  // namespace bullet_ccd::grasp
