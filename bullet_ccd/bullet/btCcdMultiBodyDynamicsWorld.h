/// btMultiBodyDynamicsWorld with continuous collision detection for rigid bodies and multibodies.
#ifndef BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H
#define BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H

#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

/// Drop-in for btMultiBodyDynamicsWorld. Everything works as there, but the motion that a step
/// commits goes from impact to impact instead of jumping.
///
/// Positions are integrated at the solved velocities up to the first time at which two colliders
/// come too near (see btCcdControl). There the listener is told, and the solver answers the impact
/// with Bullet's restitution and friction. Then the step goes on with the new velocities. No body
/// loses motion, unless it uses up its part of the budget of the step (btCcdBudget) and is held for
/// the rest of it.
///
/// Guarantee: that of btCcdControl, and a step without an impact is Bullet's own, bit for bit.
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

    void solveConstraints(btContactSolverInfo & info) override;
    void integrateTransforms(btScalar timeStep) override;
    void debugDrawWorld() override;
};

#endif  // BT_CCD_MULTI_BODY_DYNAMICS_WORLD_H
