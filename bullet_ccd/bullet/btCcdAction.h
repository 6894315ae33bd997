/// Continuous collision detection for any stock world of Bullet, as an action.
#ifndef BT_CCD_ACTION_H
#define BT_CCD_ACTION_H

#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <LinearMath/btIDebugDraw.h>

/// After every step the action takes back motion that went too far. Add it to any world after all
/// other actions. In a deformable world it covers the rigid bodies and multibodies.
///
///     btCcdAction ccd(world);
///     world->addAction(&ccd);
///
/// Both bodies of an impact are put back to where they met and stay there until the step ends, or
/// until something else meets one of them: then the solver answers at once, for rigid bodies. The
/// rest of their motion in the step is lost; getCcdCounters() tells how much. Their velocities
/// stay, so the solver answers the impact in the next step. Use btCcdDiscreteDynamicsWorld or
/// btCcdMultiBodyDynamicsWorld where the class of the world can be changed: they lose no time and
/// answer at once.
///
/// Guarantee: that of btCcdControl, and a step without an impact is Bullet's own, bit for bit.
///
/// Actions and vehicles that were added earlier see the motion that is taken back. Remove the
/// action from the world before the action is destroyed.
class BULLET_CCD_API btCcdAction : public btActionInterface, public btCcdControl
{
public:
    explicit btCcdAction(btDiscreteDynamicsWorld* world);

    void updateAction(btCollisionWorld* world, btScalar timeStep) override;
    void debugDraw(btIDebugDraw* drawer) override;
};

#endif  // BT_CCD_ACTION_H
