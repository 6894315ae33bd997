#include "bullet_ccd/bullet/btCcdAction.h"

btCcdAction::btCcdAction(btDiscreteDynamicsWorld* world) : btCcdControl(*world) {}

void btCcdAction::updateAction(btCollisionWorld*, btScalar timeStep)
{
    rollBackToImpacts(timeStep);
}

void btCcdAction::debugDraw(btIDebugDraw* drawer)
{
    drawCcd(drawer);
}
