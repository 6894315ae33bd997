/// Impacts, the listener that is told of them, and the settings, counters and the way through a
/// step which the worlds and the action have in common.
#ifndef BT_CCD_CONTROL_H
#define BT_CCD_CONTROL_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/bullet/btCcdSettings.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <LinearMath/btVector3.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

class btCcdContext;
class btCcdStep;
class btIDebugDraw;
class btManifoldPoint;
class btMultiBody;

/// Two colliders that have come too near each other.
struct btCcdImpact
{
    /// Link index of a collider that belongs to no multibody.
    static constexpr int kNoLink = -2;

    btCollisionObject* m_objectA;
    btCollisionObject* m_objectB;
    int m_linkA;  ///< of a multibody; -1: its base
    int m_linkB;
    btScalar m_time;     ///< since the step began [s]
    btVector3 m_pointA;  ///< closest points at that time, in the world [m]
    btVector3 m_pointB;
    btVector3 m_normal;  ///< unit, from A to B
};

/// What was inside a trigger at some time of a step: entered it, left it, stayed in it or passed
/// through it, however fast.
///
/// A trigger is any object with CF_NO_CONTACT_RESPONSE: a btGhostObject, a body or a link. Others
/// are seen that Bullet lets collide with it (groups and masks, user filters, links); what is
/// static only by a trigger that moves. A trigger with an inside (convex shapes, and compounds of
/// these) holds what touches it or is in it; one that has none (meshes, height fields, planes) is
/// its surface.
struct btCcdPassage
{
    btCollisionObject* m_trigger;
    btCollisionObject* m_object;
    int m_triggerLink;  ///< of a multibody, as in btCcdImpact
    int m_objectLink;
    bool m_wasInside;      ///< when the step began: the step before has told of it
    bool m_isInside;       ///< when the step ended
    btScalar m_enterTime;  ///< since the step began [s]; 0 if it was inside
    btScalar m_exitTime;   ///< [s]; if it entered more than once, the last time; the step's end if
                           ///< it is inside
    btVector3 m_point;  ///< of the object, where it entered, in the world [m]; its origin if it was
                        ///< inside
    btVector3 m_normal;  ///< unit, from the trigger to the object, there; zero if it was inside
};

/// What happens to a pair after its impact.
enum class btCcdAfterImpact
{
    Solve,     ///< the solver answers at once and the step goes on; an action can only hold
    Hold,      ///< the two bodies stand still for the rest of the step
    Continue,  ///< the listener has stopped or turned the motion; the step goes on for both
};

/// What becomes of a body that has used up its part of the btCcdBudget, in this order.
enum class btCcdYield
{
    Settled,   ///< has lost its spin and its approach, and goes on
    Held,      ///< stands still for the rest of the step
    Carried,   ///< goes along with the kinematic object that pressed on it
    Squeezed,  ///< is caught between kinematic objects, or one of them and what is fixed: it stands
               ///< still, they go on into it, and Bullet's contacts have it
};

/// Is told of impacts while a step is under way. The bodies are where they are at the time of the
/// impact. An action tells of impacts after the step, with the bodies put back to where they met.
struct btCcdImpactListener
{
    virtual ~btCcdImpactListener() = default;
    /// May change velocities, but must not add or remove objects. It is safe but slow to return
    /// Continue without having ended the approach: the pair is met again a little nearer.
    virtual btCcdAfterImpact onImpact(const btCcdImpact& impact) = 0;
    /// False for a pair that is not to be swept in this step: each may go through the other unless
    /// Bullet's discrete contacts stop it. Asked for pairs that are near each other, in the middle
    /// of a step.
    virtual bool isSwept(const btCollisionObject& /*a*/, const btCollisionObject& /*b*/)
    {
        return true;
    }
    /// Told at the end of a step, in the order of m_enterTime. May add and remove objects: what is
    /// not told of any more.
    virtual void onPassage(const btCcdPassage& /*passage*/) {}
    /// The body of this collider has met its limits at the impact.
    virtual void onYield(const btCollisionObject& /*object*/,
                         btCcdYield /*how*/,
                         const btCcdImpact& /*impact*/)
    {
    }
};

/// Counts of what was done since the world or action was made or the counters were reset.
struct btCcdCounters
{
    std::int64_t m_queries = 0;      ///< pairs whose time of impact was asked for
    std::int64_t m_impacts = 0;      ///< pairs that came too near
    std::int64_t m_subSteps = 0;     ///< impacts answered by the solver in the middle of a step
    std::int64_t m_clamps = 0;       ///< bodies that were held for the rest of a step
    double m_lostTime = 0.0;         ///< motion those bodies missed, summed over them [s]
    std::int64_t m_overlaps = 0;     ///< pairs left to discrete contacts: they intersected already
    std::int64_t m_eventLimits = 0;  ///< impacts of bodies that had met their limit
    std::int64_t m_settled = 0;      ///< bodies that lost their spin and approach (btCcdYield)
    std::int64_t m_carried = 0;      ///< held bodies that a kinematic object took along
    std::int64_t m_squeezed = 0;     ///< bodies caught between kinematic objects, once a step
    std::int64_t m_iterationLimits = 0;  ///< queries that gave up (their bodies are held)
    std::int64_t m_unsupported = 0;      ///< colliders not covered in the last step
};

/// Settings and counters; base of btCcdAction, btCcdDiscreteDynamicsWorld and
/// btCcdMultiBodyDynamicsWorld.
///
/// Guarantee of all three: two covered colliders that are apart when a step begins are not driven
/// through each other by the motion that the step commits, however fast, thin or curved it is.
/// Meshes (btCcdMeshShape, GImpact, mesh against mesh) do not even touch: they keep a quarter of
/// the sum of their margins, or, pressed nearer by what the solver allows, lose no more than a
/// quarter of the distance in a step. Stock shapes may sink in as deep as Bullet's solver lets
/// them, but not to their cores, the shapes shrunk to about half their depth. Not seen: motion that
/// is not velocity (setWorldTransform, setJointPos); pairs that intersect are Bullet's until they
/// part. Kinematic bodies move from the pose that they had to the pose that they have been given.
/// Covered: boxes, spheres, capsules, cylinders, cones, convex hulls, meshes, height fields,
/// planes and compounds of these on rigid bodies, multibodies (revolute, prismatic, spherical,
/// planar and fixed joints, fixed or floating base) and objects at rest.
class BULLET_CCD_API btCcdControl
{
public:
    /// Registers btCcdCollisionAlgorithm with the world's dispatcher if that was not done. Throws
    /// std::invalid_argument if that is no btCollisionDispatcher.
    explicit btCcdControl(btDiscreteDynamicsWorld& world);
    virtual ~btCcdControl();
    btCcdControl(const btCcdControl&) = delete;
    btCcdControl& operator=(const btCcdControl&) = delete;

    /// All settings at once; they hold from the next step on. The setters below change single ones
    /// of them. Throws std::invalid_argument that names the value, and changes nothing, for one
    /// that is out of its range.
    void setCcdSettings(const btCcdSettings& settings);
    const btCcdSettings& getCcdSettings() const { return m_settings; }
    /// Settings of one object, in place of btCcdSettings::m_objects; before or after it has been
    /// added. They stay until resetCcdSettings(object), which has to come before the object is
    /// destroyed.
    void setCcdSettings(const btCollisionObject* object, const btCcdObjectSettings& settings);
    const btCcdObjectSettings& getCcdSettings(const btCollisionObject* object) const;
    void resetCcdSettings(const btCollisionObject* object);

    void setCcdTolerance(double tolerance);
    double getCcdTolerance() const;
    /// The tolerance, as the accuracy that a simulation needs: objects that meet do so at a gap
    /// within it, any gap (btCcdSettings::m_anyWithin). btCcdReducedMesh makes shapes of no more
    /// triangles than that needs.
    /// Throws std::invalid_argument that names smallestCcdAccuracy(), and changes nothing, for less
    /// than that, which the objects that are in the world now could not keep.
    void setCcdAccuracy(double accuracy);
    /// The smallest accuracy that holds for what is in the world now [m]: the sum of the two
    /// largest margins of meshes, at which these are stopped, and a thousand times the rounding of
    /// the largest coordinate in the precision of Bullet, whichever is more.
    double smallestCcdAccuracy() const;
    void setCcdBudget(const btCcdBudget& budget);
    const btCcdBudget& getCcdBudget() const;
    /// The mode of the object's settings: Off, or that of the others again (Full, if these are
    /// off).
    void setCcdEnabled(const btCollisionObject* object, bool enabled);
    bool isCcdEnabled(const btCollisionObject* object) const;
    /// To be called after the object has been put elsewhere (setWorldTransform), before the next
    /// step: nothing is swept on the way. A kinematic object that comes farther than four times its
    /// reach in a step, and more than twice as far as before, is taken to have jumped without that.
    void teleported(const btCollisionObject* object);
    /// The listener is not owned. Without one (null) the solver answers all impacts.
    void setCcdImpactListener(btCcdImpactListener* listener);

    /// The first impact of the two in the step that has been done last, or is under way; in either
    /// order; null if they have not met. For contact callbacks, which Bullet calls when the next
    /// step begins. Valid until then; the first thousand impacts of a step are kept.
    const btCcdImpact* findCcdImpact(const btCollisionObject* a, const btCollisionObject* b) const;

    /// What was inside triggers in the step that has been done last, in the order of m_enterTime.
    /// Valid until the next step; objects that the listener has removed have been taken out.
    const std::vector<btCcdPassage>& getCcdPassages() const;

    /// The link and all its ancestors freeze at the link's next impact. The rest of the multibody
    /// goes on without loss of time. btCcdStopLink() names the colliders that are needed.
    /// @param link -1: the base
    void stopLinkOnFirstContact(btMultiBody* body, int link);

    const btCcdCounters& getCcdCounters() const;
    /// Total time for which the body of this collider was held [s].
    double getCcdLostTime(const btCollisionObject* object) const;
    void resetCcdCounters();
    /// Level of the bounding volumes that debugDrawWorld() draws in wire frame mode, beside the
    /// boxes that fast objects swept and the impacts of the last step.
    void setCcdDrawLevel(int level);
    /// Converts the shape now, and keeps its hierarchies in btCcdSettings::m_hierarchyFolder. Else
    /// that is done when the first object with the shape is in a step. Not needed for
    /// btCcdMeshShape, which is what it is from the start.
    /// @return false if no part of the shape is covered
    bool prepareCcdShape(const btCollisionShape* shape);
    /// Call it for a shape that was changed in place.
    void forgetCcdShape(const btCollisionShape* shape);

protected:
    /// Moves a rigid body at its velocity for the given time, or all multibodies (null).
    using Integrate = std::function<void(btRigidBody*, btScalar)>;

    /// The solver of a step is about to begin. Only worlds that call it may; it is quicker then.
    void noteBeforeSolving();
    /// The way of a world through the integration of a step: beginStep(); if something may meet,
    /// integrateFromImpactToImpact(), else the integration of stock Bullet; endStep().
    [[nodiscard]] bool beginStep(btScalar timeStep);
    /// Bodies move when an impact concerns them, or at the end.
    void integrateFromImpactToImpact(btScalar timeStep, const Integrate& integrate);
    void endStep();
    /// The step has been done: takes back what went too far.
    void rollBackToImpacts(btScalar timeStep);
    /// Hierarchies, boxes swept by fast objects, and impacts of the last step; nothing without a
    /// drawer or in a mode without wire frames.
    void drawCcd(btIDebugDraw* drawer);

private:
    btDiscreteDynamicsWorld& m_world;
    std::unique_ptr<btCcdStep> m_step;
    btCcdContext& m_context;
    btCcdSettings m_settings;

    friend std::optional<btCcdImpact> btCcdImpactOf(const btManifoldPoint& point,
                                                    const btCollisionObject* a,
                                                    const btCollisionObject* b);
};

/// The impact that a contact point comes from: of those of the two objects in the last step of
/// their world, the one that was nearest to the point, seen from `a` (m_objectA is a). Nothing if
/// they have not met. For gContactAddedCallback and gContactProcessedCallback, which know no world;
/// a point's m_userPersistentData is the user's alone.
BULLET_CCD_API std::optional<btCcdImpact> btCcdImpactOf(const btManifoldPoint& point,
                                                        const btCollisionObject* a,
                                                        const btCollisionObject* b);

/// Freezes `link` and all its ancestors. They become kinematic with zero velocity, so Bullet leaves
/// their joints out of the dynamics, and what they carry cannot push them away. A motor at zero
/// velocity, or equal limits, would yield under load. The base becomes kinematic, too, which is
/// exact only for a fixed base. setLinkDynamicType(i, CF_DYNAMIC_OBJECT) and setBaseDynamicType()
/// undo it.
/// @return false, with nothing done, if one of these links or the base has no collider
/// @param link -1: the base alone
BULLET_CCD_API bool btCcdStopLink(btMultiBody& body, int link);

#endif  // BT_CCD_CONTROL_H
