/// Continuous collision detection for a world of Bullet's own.
#ifndef BT_CCD_ACTION_H
#define BT_CCD_ACTION_H

#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <LinearMath/btIDebugDraw.h>

/// Add it to any world after all other actions (rigid, multibody, deformable: there for the rigid
/// bodies and multibodies in it) and it takes back, after every step, what went too far:
///
///     btCcdAction ccd(world);
///     world->addAction(&ccd);
///
/// Both bodies of an impact are put back to where they met, and stay there until the step ends: the
/// rest of their motion in it is lost (getCcdCounters() tells how much). Their velocities stay, so
/// that the solver answers in the next step. A step without an impact is not touched, bit for bit.
/// btCcdDiscreteDynamicsWorld and btCcdMultiBodyDynamicsWorld lose no time and answer at once: use
/// them where the class of the world can be changed.
///
/// Actions and vehicles that were added before see the motion that is taken back. Remove it from
/// the world before it is destroyed.
class BULLET_CCD_API btCcdAction : public btActionInterface, public btCcdControl
{
public:
    explicit btCcdAction(btDiscreteDynamicsWorld* world);

    void updateAction(btCollisionWorld* world, btScalar timeStep) override;
    void debugDraw(btIDebugDraw* drawer) override;
};

#endif  // BT_CCD_ACTION_H
