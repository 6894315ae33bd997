/// Which two objects a step need not be asked about.
#ifndef BT_CCD_PAIR_RULES_H
#define BT_CCD_PAIR_RULES_H

#include "bullet_ccd/bullet/step/btCcdTracker.h"

class btCcdContext;

/// True if Bullet lets the two collide: groups and masks, user filters, parent-child and
/// self-collision flags, contact response.
[[nodiscard]] bool btCcdMayMeet(btCollisionWorld& world,
                                const btCollisionObject& a,
                                const btCollisionObject& b);

/// What the two may move relative to each other and not cross [m]. Infinite if one of them turns
/// out to have nothing that could be hit.
[[nodiscard]] double btCcdMayLose(btCcdContext& context,
                                  const btCcdTracked& a,
                                  const btCcdTracked& b);

/// Where the object is when the step begins (`done`: when it ends); a link, where the joints of its
/// multibody have it.
[[nodiscard]] btTransform btCcdPoseOf(const btCcdTracked& tracked, bool done);

/// True if the two are certainly this much farther apart [m] than all distances that matter to
/// contacts and to queries.
[[nodiscard]] bool btCcdAreFartherApart(const btCcdContext& context,
                                        const btCcdTracked& a,
                                        const btCcdTracked& b,
                                        double distance,
                                        bool done);

#endif  // BT_CCD_PAIR_RULES_H
