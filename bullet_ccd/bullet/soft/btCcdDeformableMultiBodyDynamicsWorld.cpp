#include "bullet_ccd/bullet/btCcdDeformableMultiBodyDynamicsWorld.h"

btCcdDeformableMultiBodyDynamicsWorld::btCcdDeformableMultiBodyDynamicsWorld(
    btDispatcher* dispatcher,
    btBroadphaseInterface* pairCache,
    btDeformableMultiBodyConstraintSolver* constraintSolver,
    btCollisionConfiguration* collisionConfiguration,
    btCcdDeformableBodySolver* deformableBodySolver)
    : btDeformableMultiBodyDynamicsWorld(
          dispatcher, pairCache, constraintSolver, collisionConfiguration, deformableBodySolver),
      btCcdControl(static_cast<btDiscreteDynamicsWorld&>(*this)),
      m_ccdSolver(deformableBodySolver)
{
}

void btCcdDeformableMultiBodyDynamicsWorld::integrateTransforms(btScalar timeStep)
{
    positionCorrection(timeStep);
    if (beginStep(timeStep))
    {
        integrateFromImpactToImpact(timeStep,
                                    [this](btRigidBody* body, btScalar part)
                                    {
                                        if (body != nullptr)
                                        {
                                            integrateTransformsInternal(&body, 1, part);
                                        }
                                        else
                                        {
                                            integrateMultiBodyTransforms(part);
                                        }
                                    });
        if (getApplySpeculativeContactRestitution())
        {
            btDiscreteDynamicsWorld::integrateTransforms(btScalar(0));
        }
    }
    else
    {
        btMultiBodyDynamicsWorld::integrateTransforms(timeStep);
    }
    m_ccdSolver->applyTransforms(timeStep);
    endStep();
}

void btCcdDeformableMultiBodyDynamicsWorld::debugDrawWorld()
{
    btDeformableMultiBodyDynamicsWorld::debugDrawWorld();
    drawCcd(getDebugDrawer());
    m_ccdSolver->debugDraw(getDebugDrawer());
}
