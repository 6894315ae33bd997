/// btMultiBodyDynamicsWorld with continuous collision detection for rigid bodies and multibodies.
#ifndef BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H
#define BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H

#include "bullet_ccd/bullet/btCcdStepper.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

class btRigidBody;

/// What the world did since it was made or the counters were reset.
struct btCcdCounters
{
    std::int64_t m_queries = 0;      ///< time-of-impact queries
    std::int64_t m_impacts = 0;      ///< pairs that came within the tolerance
    std::int64_t m_clamps = 0;       ///< bodies that were held for the rest of a step
    double m_lostTime = 0.0;         ///< motion those bodies missed, summed over them [s]
    std::int64_t m_overlaps = 0;     ///< pairs left to discrete contacts: they intersected already
    std::int64_t m_eventLimits = 0;  ///< steps cut short by the limit of impacts per step
    std::int64_t m_iterationLimits = 0;  ///< steps cut short because a query gave up
    std::int64_t m_unsupported = 0;      ///< colliders not covered in the last query
};

/// What happens to a pair after its impact.
enum class btCcdAfterImpact
{
    Hold,      ///< the two bodies stand still for the rest of the step
    Continue,  ///< the listener has stopped or turned the motion; the step goes on for both
};

/// Is told of impacts while the step is under way, the bodies where they are at that moment.
struct btCcdImpactListener
{
    virtual ~btCcdImpactListener() = default;
    /// May change velocities; must not add or remove objects. Continue without having ended the
    /// approach is safe but slow: the pair is met again at three quarters of the distance.
    virtual btCcdAfterImpact onImpact(const btCcdImpact& impact) = 0;
};

/// Drop-in for btMultiBodyDynamicsWorld: everything works as there, but the motion that a step
/// commits is advanced from impact to impact instead of jumping.
///
/// Positions are integrated at the solved velocities, as always, up to the first time at which two
/// colliders come within the tolerance; then the listener is told, the bodies concerned stop for
/// the rest of the step (next step, the discrete solver finds them in contact and answers), and the
/// others go on from there. A body that is not concerned loses nothing.
///
/// Guarantee: no pair of covered colliders that is apart when a step begins gets into contact
/// during it, however fast, thin or curved the motion; exceptions: pairs of two stock shapes that
/// already have a contact point within the tolerance are left to Bullet's solver until they part
/// (they rest at distance zero), and motion that is not velocity (setWorldTransform, setJointPos,
/// kinematic motion states, split impulses) is not seen. Covered: shapes of btCcdShapeCache on
/// rigid bodies (any), multibodies with revolute, prismatic and fixed joints (fixed or floating
/// base), and objects at rest. Covered rigid bodies are exempt from Bullet's own continuous motion
/// clamping.
///
/// A btCcdMeshShape needs a margin above the tolerance, so that the solver keeps resting bodies out
/// of the reach of the time of impact. Two btCcdMeshShapes have no discrete contacts: they stop
/// each other but do not push.
ATTRIBUTE_ALIGNED16(class)
btCcdMultiBodyDynamicsWorld : public btMultiBodyDynamicsWorld
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    static constexpr double kDefaultTolerance = 2e-4;  ///< [m]
    static constexpr int kDefaultMaxEvents = 64;

    btCcdMultiBodyDynamicsWorld(btDispatcher * dispatcher,
                                btBroadphaseInterface * pairCache,
                                btMultiBodyConstraintSolver * constraintSolver,
                                btCollisionConfiguration * collisionConfiguration);

    /// Distance at which bodies are stopped [m], > 0. Sensible: 1/1000 to 1/100 of the smallest
    /// thing in the world; in single precision at least 1000 times the rounding of the largest
    /// coordinate.
    void setCcdTolerance(double tolerance);
    double getCcdTolerance() const
    {
        return m_tolerance;
    }
    /// Impacts answered one after the other in a step; then everything is held.
    void setCcdMaxEvents(int maxEvents)
    {
        m_maxEvents = maxEvents;
    }
    /// Not owned; null for none (then every impact holds its bodies).
    void setCcdImpactListener(btCcdImpactListener * listener)
    {
        m_listener = listener;
    }

    /// The link and all its ancestors freeze at the link's next impact, see btCcdStopLink (which
    /// names the colliders that are needed). The rest of the multibody goes on without loss of
    /// time.
    /// @param link -1: the base
    void stopLinkOnFirstContact(btMultiBody * body, int link);

    const btCcdCounters& getCcdCounters() const
    {
        return m_counters;
    }
    void resetCcdCounters()
    {
        m_counters = {};
    }
    /// For shapes that were changed in place.
    void forgetCcdShape(const btCollisionShape* shape)
    {
        m_stepper.shapes().forget(shape);
    }

    void integrateTransforms(btScalar timeStep) override;

private:
    /// A body whose velocity is zero for the rest of the step, and what it was.
    struct Held
    {
        btMultiBody* m_multiBody;  // one of the two
        btRigidBody* m_rigidBody;
        btVector3 m_linear;
        btVector3 m_angular;
        std::vector<btScalar> m_joints;
    };
    /// A body that turns faster than Bullet's integrator lets it in one step.
    struct Limited
    {
        btMultiBody* m_multiBody;
        btRigidBody* m_rigidBody;
        btVector3 m_wanted;
        btVector3 m_limited;
    };

    btCcdStepper m_stepper;
    btCcdImpactListener* m_listener = nullptr;
    double m_tolerance = kDefaultTolerance;
    int m_maxEvents = kDefaultMaxEvents;
    btCcdCounters m_counters;
    std::set<std::pair<btMultiBody*, int>> m_stopLinks;
    std::vector<Held> m_held;
    std::vector<Limited> m_limitedSpins;
    std::vector<std::pair<btRigidBody*, btScalar>> m_stockThresholds;

    void beginStep(btScalar timeStep);
    void endStep();
    void respond(const btCcdImpact& impact, btScalar remaining);
    bool stopWatchedLink(const btCollisionObject* object, int link);
    void hold(btCollisionObject * object, btScalar remaining);
    void holdMultiBody(btMultiBody & body, btScalar remaining);
    void holdRigidBody(btRigidBody & body, btScalar remaining);
    void holdEverything(btScalar remaining);
    void countHold(btScalar remaining);
};

#endif  // BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H
