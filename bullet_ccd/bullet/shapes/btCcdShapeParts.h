/// Conversion of one collision shape that is not a compound: used by btCcdShapeCache only.
#ifndef BT_CCD_SHAPE_PARTS_H
#define BT_CCD_SHAPE_PARTS_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

/// The shape as it is now, its hierarchies shared with whoever keeps equal ones in `trees`.
/// Empty if the shape is not covered: its type, no extent, coordinates that are not finite.
std::optional<btCcdShapePart> btCcdConvertShape(const btCollisionShape& shape,
                                                btCcdTreeStore& trees);

/// A piece of a plane, z = 0, that reaches at least so far from the middle; every size that is
/// asked for is made once. What is larger is less exact: 64 m as a rule.
[[nodiscard]] std::shared_ptr<const bullet_ccd::SsvTree> btCcdPlanePiece(double half);

#endif  // BT_CCD_SHAPE_PARTS_H
