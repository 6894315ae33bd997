/// What the worlds and the action have in common: settings, counters, and the way through a step.
#ifndef BT_CCD_CONTROL_H
#define BT_CCD_CONTROL_H

#include "bullet_ccd/bullet/step/btCcdImpactSolver.h"
#include "bullet_ccd/bullet/step/btCcdStepper.h"

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

class btCcdContext;
class btIDebugDraw;
class btMultiBody;
class btMultiBodyDynamicsWorld;
class btRigidBody;

/// What was done since the world or action was made or the counters were reset.
struct btCcdCounters
{
    std::int64_t m_queries = 0;      ///< pairs whose time of impact was asked for
    std::int64_t m_impacts = 0;      ///< pairs that came too near
    std::int64_t m_subSteps = 0;     ///< impacts answered by the solver in the middle of a step
    std::int64_t m_clamps = 0;       ///< bodies that were held for the rest of a step
    double m_lostTime = 0.0;         ///< motion those bodies missed, summed over them [s]
    std::int64_t m_overlaps = 0;     ///< pairs left to discrete contacts: they intersected already
    std::int64_t m_eventLimits = 0;  ///< steps in which a body met its limit of impacts
    std::int64_t m_iterationLimits = 0;  ///< queries that gave up (their bodies are held)
    std::int64_t m_unsupported = 0;      ///< colliders not covered in the last step
};

/// What happens to a pair after its impact.
enum class btCcdAfterImpact
{
    Solve,     ///< the solver answers at once and the step goes on; an action can only hold
    Hold,      ///< the two bodies stand still for the rest of the step
    Continue,  ///< the listener has stopped or turned the motion; the step goes on for both
};

/// Is told of impacts while the step is under way, the bodies where they are at that moment (with
/// an action: after it, for the bodies have been moved to where they met).
struct btCcdImpactListener
{
    virtual ~btCcdImpactListener() = default;
    /// May change velocities; must not add or remove objects. Continue without having ended the
    /// approach is safe but slow: the pair is met again a little nearer.
    virtual btCcdAfterImpact onImpact(const btCcdImpact& impact) = 0;
};

/// Settings and counters; base of btCcdAction, btCcdDiscreteDynamicsWorld and
/// btCcdMultiBodyDynamicsWorld.
///
/// Guarantee of all three: no two covered colliders that are apart when a step begins are driven
/// through each other by the motion that the step commits, however fast, thin or curved it is.
/// Meshes (btCcdMeshShape, GImpact, mesh against mesh) do not even touch: they keep a quarter of
/// the sum of their margins, or, pressed nearer by what the solver allows, lose no more than a
/// quarter of the distance in a step. Stock shapes may sink in as deep as Bullet's solver lets
/// them, but not to their cores (btCcdShapePart::m_core). Not seen: motion that is not velocity
/// (setWorldTransform, setJointPos, split impulses); kinematic bodies are taken to go on at the
/// velocity of their last two poses; pairs that intersect are Bullet's until they part.
/// Covered: shapes of btCcdShapeCache on rigid bodies, multibodies (revolute, prismatic, spherical,
/// planar and fixed joints, fixed or floating base) and objects at rest.
class btCcdControl
{
public:
    static constexpr int kDefaultMaxEvents = 24;

    /// Registers btCcdCollisionAlgorithm with the world's dispatcher if that was not done.
    explicit btCcdControl(btDiscreteDynamicsWorld& world);
    virtual ~btCcdControl();
    btCcdControl(const btCcdControl&) = delete;
    btCcdControl& operator=(const btCcdControl&) = delete;

    /// Distance at which stock shapes count as touching [m], > 0. Sensible: 1/1000 to 1/100 of the
    /// smallest thing in the world; in single precision at least 1000 times the rounding of the
    /// largest coordinate. (Meshes are stopped by their margins.)
    void setCcdTolerance(double tolerance);
    double getCcdTolerance() const;
    /// Impacts of one body in one step; then it is settled (it loses its spin and its approach),
    /// and held for the rest of the step if that is in vain.
    void setCcdMaxEvents(int maxEvents) { m_maxEvents = maxEvents; }
    /// All objects are covered unless excluded here. Excluded ones keep all of stock Bullet,
    /// including its own motion clamping. Take an object back before it is destroyed.
    void setCcdEnabled(const btCollisionObject* object, bool enabled);
    bool isCcdEnabled(const btCollisionObject* object) const;
    /// Not owned; null for none (then the solver answers).
    void setCcdImpactListener(btCcdImpactListener* listener) { m_listener = listener; }

    /// The link and all its ancestors freeze at the link's next impact, see btCcdStopLink (which
    /// names the colliders that are needed). The rest of the multibody goes on without loss of
    /// time.
    /// @param link -1: the base
    void stopLinkOnFirstContact(btMultiBody* body, int link);

    const btCcdCounters& getCcdCounters() const { return m_counters; }
    /// Time that the body of this collider was held, in all [s].
    double getCcdLostTime(const btCollisionObject* object) const;
    void resetCcdCounters();
    /// Level of the bounding volumes that debugDrawWorld() draws in wire frame mode, beside the
    /// boxes that fast objects swept and the impacts of the last step.
    void setCcdDrawLevel(int level) { m_drawLevel = level; }
    /// For shapes that were changed in place.
    void forgetCcdShape(const btCollisionShape* shape);

protected:
    using Integrate = std::function<void(btScalar)>;

    /// The way of a world through the integration of a step: beginStep(); if something may meet,
    /// integrateFromImpactToImpact(), else the integration of stock Bullet; endStep().
    [[nodiscard]] bool beginStep(btScalar timeStep);
    /// `integrate` moves everything at its velocity for the given time.
    void integrateFromImpactToImpact(btScalar timeStep, const Integrate& integrate);
    void endStep();
    /// The step has been done: takes back what went too far.
    void rollBackToImpacts(btScalar timeStep);
    /// Hierarchies, boxes swept by fast objects, and impacts of the last step; nothing without a
    /// drawer or in a mode without wire frames.
    void drawCcd(btIDebugDraw* drawer);

private:
    /// A rigid body or multibody.
    struct Body
    {
        btRigidBody* m_rigidBody = nullptr;
        btMultiBody* m_multiBody = nullptr;

        friend auto operator<=>(const Body&, const Body&) = default;
        [[nodiscard]] bool isNone() const
        {
            return m_rigidBody == nullptr && m_multiBody == nullptr;
        }
    };
    /// An impact and where its colliders were then.
    struct SeenImpact
    {
        btCcdImpact m_impact;
        btTransform m_poseA;
        btTransform m_poseB;
    };
    /// A body whose velocity is zero for the rest of the step, and what it was.
    struct Held
    {
        Body m_body;
        btVector3 m_linear;
        btVector3 m_angular;
        std::vector<btScalar> m_joints;
    };
    /// What turns faster than Bullet's integrator lets it in one step.
    struct Limited
    {
        Body m_body;
        int m_link;                           // a spherical joint's, else kBase
        const btCollisionObject* m_collider;  // of the body
        btVector3 m_wanted;
        btVector3 m_limited;
    };
    static constexpr int kBase = -1;

    btDiscreteDynamicsWorld& m_world;
    btMultiBodyDynamicsWorld* m_multiBodyWorld;  // the same, or null
    btCcdContext& m_context;
    btCcdStepper m_stepper;
    btCcdImpactSolver m_solver;
    btCcdImpactListener* m_listener = nullptr;
    int m_maxEvents = kDefaultMaxEvents;
    btCcdCounters m_counters;
    std::vector<SeenImpact> m_lastImpacts;  // of the last step, for drawing
    int m_drawLevel = 0;
    std::map<Body, double> m_lostTimes;
    std::set<std::pair<btMultiBody*, int>> m_stopLinks;
    std::map<Body, int> m_events;  // of this step
    std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, int> m_pairEvents;
    std::vector<Held> m_held;
    std::vector<Limited> m_limitedSpins;
    std::set<Body> m_spinning;  // since an impact of this step
    std::vector<std::pair<btRigidBody*, btScalar>> m_stockThresholds;

    [[nodiscard]] static Body bodyOf(btCollisionObject* object);
    void suspendStockClamping();
    void limitSpins(btScalar timeStep);
    void integrateInPieces(btScalar time, const Integrate& integrate);
    [[nodiscard]] static btVector3 spinOf(const Body& body, int link);
    static void setSpin(const Body& body, int link, const btVector3& spin);
    void limitSpins(const Body& body, const btCollisionObject* collider, btScalar timeStep);
    void restoreSpins();
    void spinFreely();
    void releaseHeld();
    void respond(const btCcdStepper::Event& event, btScalar remaining);
    void solve(const std::vector<btCcdImpact>& impacts, bool bouncing);
    void calmDown(btCollisionObject* object);
    [[nodiscard]] bool isDone(const btCcdImpact& impact, btScalar remaining);
    bool settle(const btCcdImpact& impact);
    [[nodiscard]] static btVector3 velocityOf(const Body& body);
    [[nodiscard]] static btScalar mobilityOf(const Body& body);
    static void slide(const Body& body, const btVector3& impulse);
    [[nodiscard]] bool meetsLimit(const btCcdImpact& impact);
    bool stopWatchedLink(const btCollisionObject* object, int link);
    void hold(btCollisionObject* object, btScalar remaining);
    void placeBack(btCollisionObject* object, btScalar remaining);
    void countHold(const Body& body, btScalar remaining);
    void countQueries();
    void note(const btCcdImpact& impact);
};

#endif  // BT_CCD_CONTROL_H
