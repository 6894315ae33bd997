/// btMultiBodyDynamicsWorld with continuous collision detection for rigid bodies and multibodies.
#ifndef BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H
#define BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H

#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

/// Drop-in for btMultiBodyDynamicsWorld: everything works as there, but the motion that a step
/// commits is advanced from impact to impact instead of jumping.
///
/// Positions are integrated at the solved velocities, as always, up to the first time at which two
/// colliders come too near (see btCcdControl); there the listener is told, the solver answers the
/// impact with Bullet's restitution and friction, and the step goes on with the new velocities. A
/// step without an impact is Bullet's own, bit for bit. Bodies that the impact does not concern
/// lose nothing; those that it concerns lose nothing either, unless they meet their limit of
/// impacts in the step (setCcdMaxEvents) and are held for the rest of it.
///
/// Covered rigid bodies are exempt from Bullet's own continuous motion clamping.
ATTRIBUTE_ALIGNED16(class)
BULLET_CCD_API btCcdMultiBodyDynamicsWorld : public btMultiBodyDynamicsWorld, public btCcdControl
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    btCcdMultiBodyDynamicsWorld(btDispatcher * dispatcher,
                                btBroadphaseInterface * pairCache,
                                btMultiBodyConstraintSolver * constraintSolver,
                                btCollisionConfiguration * collisionConfiguration);

    void integrateTransforms(btScalar timeStep) override;
    void debugDrawWorld() override;
};

#endif  // BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H
