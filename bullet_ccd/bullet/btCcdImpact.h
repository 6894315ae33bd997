/// Impacts, and who is told of them.
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
    int m_linkA;  ///< -1: the base of a multibody
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

/// Is told of impacts while the step is under way, the bodies where they are at that moment (with
/// an action: after it, for the bodies have been moved to where they met).
struct btCcdImpactListener
{
    virtual ~btCcdImpactListener() = default;
    /// May change velocities; must not add or remove objects. Continue without having ended the
    /// approach is safe but slow: the pair is met again a little nearer.
    virtual btCcdAfterImpact onImpact(const btCcdImpact& impact) = 0;
};

#endif  // BT_CCD_IMPACT_H
