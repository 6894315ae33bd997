/// Stopping a link of a multibody for good.
#ifndef BT_CCD_STOP_LINK_H
#define BT_CCD_STOP_LINK_H

#include "bullet_ccd/bullet/btCcdPrecision.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>

/// Freezes `link` and all its ancestors: they become kinematic with zero velocity, so that Bullet
/// leaves their joints out of the dynamics and what they carry cannot push them away. (A motor at
/// zero velocity or equal limits yield under load.) The base becomes kinematic too: exact only for
/// a fixed base. All of these links and the base need a collider; false (and nothing done) if one
/// is missing. Undo with setLinkDynamicType(i, CF_DYNAMIC_OBJECT) and setBaseDynamicType.
/// @param link -1: the base alone
BULLET_CCD_API bool btCcdStopLink(btMultiBody& body, int link);

#endif  // BT_CCD_STOP_LINK_H
