/// Conversion of one collision shape that is not a compound: used by btCcdShapeCache only.
#ifndef BT_CCD_SHAPE_PARTS_H
#define BT_CCD_SHAPE_PARTS_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

/// The shape as it is now, its hierarchies shared with whoever keeps equal ones in `trees`.
/// Empty if the shape is not covered: its type, no extent, coordinates that are not finite.
std::optional<btCcdShapePart> btCcdConvertShape(const btCollisionShape& shape,
                                                btCcdTreeStore& trees);

#endif  // BT_CCD_SHAPE_PARTS_H
