#include "bullet_ccd/bullet/btCcdDeformableMultiBodyDynamicsWorld.h"

#include "bullet_ccd/bullet/step/btCcdContext.h"

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
    btCcdContext::of(*dispatcher).m_coversSoftBodies = true;
}

void btCcdDeformableMultiBodyDynamicsWorld::integrateTransforms(btScalar timeStep)
{
    positionCorrection(timeStep);
    if (beginStep(timeStep))
    {
        integrateFromImpactToImpact(timeStep,
                                    [this](btScalar part)
                                    { btMultiBodyDynamicsWorld::integrateTransforms(part); });
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
