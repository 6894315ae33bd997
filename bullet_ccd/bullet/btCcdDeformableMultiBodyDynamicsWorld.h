/// btDeformableMultiBodyDynamicsWorld with continuous collision detection for everything in it.
#ifndef BT_CCD_DEFORMABLE_MULTI_BODY_DYNAMICS_WORLD_H
#define BT_CCD_DEFORMABLE_MULTI_BODY_DYNAMICS_WORLD_H

#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"

#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>

/// Drop-in for btDeformableMultiBodyDynamicsWorld. Rigid bodies and multibodies go from impact to
/// impact as in btCcdMultiBodyDynamicsWorld; then soft bodies are checked against where these went,
/// as btCcdDeformableBodySolver says.
///
/// Guarantee: those of btCcdControl and of btCcdDeformableBodySolver. A rigid body that squeezes a
/// soft one against something is held back for the step, along the way it came; other rigid bodies
/// are checked against it there, come along with it, or are held back as well.
ATTRIBUTE_ALIGNED16(class)
BULLET_CCD_API btCcdDeformableMultiBodyDynamicsWorld : public btDeformableMultiBodyDynamicsWorld,
                                                       public btCcdControl
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    /// The solver is not owned; it belongs into the constraint solver, too (setDeformableSolver).
    btCcdDeformableMultiBodyDynamicsWorld(btDispatcher * dispatcher,
                                          btBroadphaseInterface * pairCache,
                                          btDeformableMultiBodyConstraintSolver * constraintSolver,
                                          btCollisionConfiguration * collisionConfiguration,
                                          btCcdDeformableBodySolver * deformableBodySolver);

    void debugDrawWorld() override;

protected:
    void integrateTransforms(btScalar timeStep) override;

private:
    btCcdDeformableBodySolver* m_ccdSolver;
};

#endif  // BT_CCD_DEFORMABLE_MULTI_BODY_DYNAMICS_WORLD_H
