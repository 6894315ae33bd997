/// Impacts, and the listener that is told of them.
#ifndef BT_CCD_IMPACT_H
#define BT_CCD_IMPACT_H

#include "bullet_ccd/bullet/btCcdPrecision.h"

#include <LinearMath/btVector3.h>

class btCollisionObject;

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
    /// The body of this collider has met its limits at the impact.
    virtual void onYield(const btCollisionObject& /*object*/,
                         btCcdYield /*how*/,
                         const btCcdImpact& /*impact*/)
    {
    }
};

#endif  // BT_CCD_IMPACT_H
