#include "bullet_ccd/bullet/btCcdDiscreteDynamicsWorld.h"

btCcdDiscreteDynamicsWorld::btCcdDiscreteDynamicsWorld(
    btDispatcher* dispatcher,
    btBroadphaseInterface* pairCache,
    btConstraintSolver* constraintSolver,
    btCollisionConfiguration* collisionConfiguration)
    : btDiscreteDynamicsWorld(dispatcher, pairCache, constraintSolver, collisionConfiguration),
      btCcdControl(static_cast<btDiscreteDynamicsWorld&>(*this))
{
}

void btCcdDiscreteDynamicsWorld::solveConstraints(btContactSolverInfo& info)
{
    noteBeforeSolving();
    btDiscreteDynamicsWorld::solveConstraints(info);
}

void btCcdDiscreteDynamicsWorld::integrateTransforms(btScalar timeStep)
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
                                    });
        if (getApplySpeculativeContactRestitution())
        {
            btDiscreteDynamicsWorld::integrateTransforms(btScalar(0));
        }
    }
    else
    {
        btDiscreteDynamicsWorld::integrateTransforms(timeStep);
    }
    endStep();
}

void btCcdDiscreteDynamicsWorld::debugDrawWorld()
{
    btDiscreteDynamicsWorld::debugDrawWorld();
    drawCcd(getDebugDrawer());
}
