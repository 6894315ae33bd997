/// Time of impact of two collision objects whose models and motions are known.
#ifndef BT_CCD_PAIR_TOI_H
#define BT_CCD_PAIR_TOI_H

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/motion/btCcdObjectMotion.h"
#include "bullet_ccd/bullet/step/btCcdManifolds.h"

struct btCcdSide
{
    const btCcdShapeModel& m_model;
    const btCcdObjectMotion& m_motion;
};

/// True if the discrete contacts of the two shapes are this library's: at least one is a
/// btCcdMeshShape or GImpact mesh, or neither has an inside.
[[nodiscard]] bool btCcdHasOwnContacts(const btCcdShapePart& a, const btCcdShapePart& b);

/// How far two parts may approach each other from where discrete contacts leave them at rest,
/// before anything can be lost [m].
[[nodiscard]] double btCcdReserve(const btCcdShapeModel& a, const btCcdShapeModel& b);

/// First time at which the objects come too near.
///
/// Where contacts are the library's own, their solver keeps pairs at the shell m, the sum of the
/// margins. A pair farther apart is stopped just above m; one within the shell belongs to the
/// solver and is stopped at m / 4; one nearer still may lose a quarter of its distance. What
/// intersects, or is wholly inside, is stopped where it would be if A were moved out of B
/// (`known.m_wayOut`), so it comes at most 3 m / 4 deeper; where no way out is known it goes on.
///
/// Where contacts are Bullet's, shapes come to rest at distance 0, or a little below. A pair apart
/// is stopped within `tolerance` of touching; one that touches belongs to the solver, and is
/// stopped when the cores of the shapes (btCcdShapePart::m_core) meet: so it can rest, slide and
/// roll, but not pass.
/// @param tolerance [m], for pairs with Bullet's contacts
/// @param anyWithin  a pair farther apart than m may be stopped anywhere down to 3 m / 8
/// @param known      what the contacts of the two tell: nothing of shapes of several parts
[[nodiscard]] btCcdPairToi btCcdTimeOfImpact(const btCcdSide& a,
                                             const btCcdSide& b,
                                             double tolerance,
                                             bool anyWithin,
                                             const btCcdKnownOfPair& known);

/// For triggers: first time at which the surfaces, without any margins of meshes, come within
/// `tolerance` [m] of each other. Overlapping if they are so near at the start, or if one begins
/// inside the other, a convex shape.
[[nodiscard]] btCcdPairToi btCcdTimeOfTouch(const btCcdSide& a,
                                            const btCcdSide& b,
                                            double tolerance);

#endif  // BT_CCD_PAIR_TOI_H
