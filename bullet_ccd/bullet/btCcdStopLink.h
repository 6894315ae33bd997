/// Stopping a link of a multibody for good.
#ifndef BT_CCD_STOP_LINK_H
#define BT_CCD_STOP_LINK_H

#include "bullet_ccd/bullet/btCcdPrecision.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>

/// Freezes `link` and all its ancestors. They become kinematic with zero velocity, so Bullet leaves
/// their joints out of the dynamics, and what they carry cannot push them away. A motor at zero
/// velocity, or equal limits, would yield under load. The base becomes kinematic, too, which is
/// exact only for a fixed base. setLinkDynamicType(i, CF_DYNAMIC_OBJECT) and setBaseDynamicType()
/// undo it.
/// @return false, with nothing done, if one of these links or the base has no collider
/// @param link -1: the base alone
BULLET_CCD_API bool btCcdStopLink(btMultiBody& body, int link);

#endif  // BT_CCD_STOP_LINK_H
