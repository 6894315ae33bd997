/// btDiscreteDynamicsWorld with continuous collision detection for everything that moves in it.
#ifndef BT_CCD_DISCRETE_DYNAMICS_WORLD_H
#define BT_CCD_DISCRETE_DYNAMICS_WORLD_H

#include "bullet_ccd/bullet/btCcdControl.h"

/// Drop-in for btDiscreteDynamicsWorld. The description of btCcdMultiBodyDynamicsWorld holds here
/// for rigid bodies.
ATTRIBUTE_ALIGNED16(class)
BULLET_CCD_API btCcdDiscreteDynamicsWorld : public btDiscreteDynamicsWorld, public btCcdControl
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    btCcdDiscreteDynamicsWorld(btDispatcher * dispatcher,
                               btBroadphaseInterface * pairCache,
                               btConstraintSolver * constraintSolver,
                               btCollisionConfiguration * collisionConfiguration);

    void solveConstraints(btContactSolverInfo & info) override;
    void integrateTransforms(btScalar timeStep) override;
    void debugDrawWorld() override;
};

#endif  // BT_CCD_DISCRETE_DYNAMICS_WORLD_H
