#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"

btCcdMultiBodyDynamicsWorld::btCcdMultiBodyDynamicsWorld(
    btDispatcher* dispatcher,
    btBroadphaseInterface* pairCache,
    btMultiBodyConstraintSolver* constraintSolver,
    btCollisionConfiguration* collisionConfiguration)
    : btMultiBodyDynamicsWorld(dispatcher, pairCache, constraintSolver, collisionConfiguration),
      btCcdControl(static_cast<btDiscreteDynamicsWorld&>(*this))
{
}

void btCcdMultiBodyDynamicsWorld::solveConstraints(btContactSolverInfo& info)
{
    noteBeforeSolving();
    btMultiBodyDynamicsWorld::solveConstraints(info);
}

void btCcdMultiBodyDynamicsWorld::integrateTransforms(btScalar timeStep)
{
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
    endStep();
}

void btCcdMultiBodyDynamicsWorld::debugDrawWorld()
{
    btMultiBodyDynamicsWorld::debugDrawWorld();
    drawCcd(getDebugDrawer());
}
