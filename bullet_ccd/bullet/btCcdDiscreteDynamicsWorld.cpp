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

void btCcdDiscreteDynamicsWorld::integrateTransforms(btScalar timeStep)
{
    integrateFromImpactToImpact(
        timeStep, [this](btScalar part) { btDiscreteDynamicsWorld::integrateTransforms(part); });
}

void btCcdDiscreteDynamicsWorld::debugDrawWorld()
{
    btDiscreteDynamicsWorld::debugDrawWorld();
    drawCcd(getDebugDrawer());
}
