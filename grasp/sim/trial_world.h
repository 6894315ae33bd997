/// A hand that drives its joints and an object that is free, in a Bullet world.
#pragma once

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"
#include "grasp/grasp_types.h"
#include "grasp/sim/hand_multi_body.h"
#include "grasp/sim/hand_pairs.h"
#include "grasp/sim/holding_solver.h"
#include "grasp/sim/joint_constraints.h"
#include "grasp/sim/resting_dispatcher.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// What the object weighs and how things rub on each other.
struct TrialBodies
{
    double mass = 0.5;      ///< of the object [kg]
    double friction = 0.5;  ///< Coulomb coefficient of all pairs
    /// Of the object, mesh frame [m]; without it, that of GraspObject.
    std::optional<Eigen::Vector3d> centerOfMass{};
    double margin = 5e-5;  ///< half of the gap at which surfaces rest on each other [m]
    /// Of the skins that fill the gap, at each contact point that is hardly compressed [N/m]; 0:
    /// rigid. Skins get harder the more the deepest point is compressed, and let nothing in by more
    /// than 0.55 of the gap: what is compressed is the gap alone, and the meshes never meet.
    double stiffness = 0.0;
    double spinDamping = 0.0;  ///< share of its spin that a free body loses in a second
};

/// The pairs of links that the hand lists, of those pairs that their groups let meet.
class TrialPairs : public HandPairs
{
public:
    using HandPairs::HandPairs;
    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        return (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
               (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0 &&
               HandPairs::needBroadphaseCollision(a, b);
    }
};

/// Forces between the hand and the object in one step.
struct HoldingForces
{
    double largest = 0.0;  ///< normal force of a contact point [N]
    double sum = 0.0;      ///< of all normal forces [N]
    int points = 0;        ///< that press
};

/// The world is that of the hand: its root link does not move. Where the hand would be accelerated,
/// the object and the table are instead, which is the same. The weight of the hand is taken as
/// compensated by its controller. The mesh frame of the object at the start is W. There is no
/// restitution and no damping except in the drives and TrialBodies::spinDamping.
///
/// Deterministic: the same calls give the same bits.
class BULLET_CCD_API TrialWorld
{
public:
    /// Keeps references to hand and object. Places the object in W and the hand, open, at
    /// `positions`.
    TrialWorld(const HandModel& hand,
               const GraspObject& object,
               const TrialBodies& bodies,
               const Eigen::Isometry3d& X_WH,
               const std::vector<double>& positions);
    ~TrialWorld();
    TrialWorld(const TrialWorld&) = delete;
    TrialWorld& operator=(const TrialWorld&) = delete;

    /// Drives the joint above `link` (movable, following no other).
    void drive(std::int32_t link, const DriveSettings& settings, double target);
    /// A table under the object, of which the hand takes no notice. Its top is the plane through
    /// `point` with the normal `up` [W, m].
    void addTable(const Eigen::Vector3d& point, const Eigen::Vector3d& up);
    /// Velocity of the table from now on [W, m/s].
    void moveTable(const Eigen::Vector3d& velocity);
    void removeTable();
    /// A body that everything meets: an obstacle at rest, or, with a mass [kg], a free one, on
    /// which the acceleration of step() acts, too. The tree is referred to and must outlive the
    /// world.
    /// @param X_WB of its mesh frame
    void addBody(const SsvTree& tree, const Eigen::Isometry3d& X_WB, double mass);

    /// One step.
    /// @param acceleration  that gravity gives the object, less that of the hand [W, m/s^2]
    /// @param force         on the object at its centre of mass [W, N]
    /// @param moment        on the object [W, N m]
    void step(double timeStep,
              const Eigen::Vector3d& acceleration,
              const Eigen::Vector3d& force,
              const Eigen::Vector3d& moment = Eigen::Vector3d::Zero());

    [[nodiscard]] Eigen::Isometry3d objectPose() const;  ///< of its mesh frame in W
    [[nodiscard]] Eigen::Isometry3d bodyPose(
        std::size_t body) const;                           ///< in the order of addBody()
    [[nodiscard]] Eigen::Vector3d objectCenter() const;    ///< of mass, W [m]
    [[nodiscard]] Eigen::Vector3d objectVelocity() const;  ///< of its centre of mass, W [m/s]
    [[nodiscard]] Eigen::Vector3d objectSpin() const;      ///< W [rad/s]
    [[nodiscard]] double objectEnergy() const;             ///< kinetic [J]
    [[nodiscard]] std::vector<double> positions() const;   ///< one entry per link [rad or m]
    /// Of the drive of the joint above `link` in the last step [N m or N].
    [[nodiscard]] double torque(std::int32_t link) const;
    [[nodiscard]] HoldingForces holdingForces() const;
    [[nodiscard]] HoldingSolver::Counters solverCounters() const { return m_solver.counters(); }
    [[nodiscard]] const btCcdCounters& ccdCounters() const { return m_world.getCcdCounters(); }

private:
    [[nodiscard]] JointDrive* driveOf(std::int32_t link) const;
    void hardenSkins();
    /// Something rigid that is no link.
    struct Body
    {
        std::unique_ptr<btCcdMeshShape> mesh;
        std::unique_ptr<btCompoundShape> shape;
        Eigen::Isometry3d X_OI;  ///< inertial frame in the mesh frame
        std::unique_ptr<btRigidBody> rigid;
    };
    [[nodiscard]] Body makeBody(const SsvTree& tree,
                                const Eigen::Isometry3d& X_WB,
                                double mass,
                                const std::optional<Eigen::Vector3d>& centerOfMass) const;

    const HandModel& m_hand;
    TrialPairs m_pairs;
    HandMultiBody m_multiBody;
    double m_objectSize;  // diagonal of its box [m]
    Body m_object;
    std::vector<Body> m_bodies;
    std::unique_ptr<btCcdMeshShape> m_tableShape;
    std::unique_ptr<btRigidBody> m_table;
    btDefaultCollisionConfiguration m_configuration;
    RestingDispatcher m_dispatcher;
    btCcdRegistration m_registration{m_dispatcher};
    btDbvtBroadphase m_broadphase;
    HoldingSolver m_solver;
    btCcdMultiBodyDynamicsWorld m_world;
    std::vector<std::unique_ptr<btMultiBodyConstraint>> m_constraints;
    std::vector<JointDrive*> m_drives;  // one entry per link; null without a motor
    double m_friction;
    double m_spinDamping;
    double m_margin;
    double m_stiffness;
    double m_timeStep = 1.0;
};
}  // namespace bullet_ccd::grasp
