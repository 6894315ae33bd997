/// What is to be known of a collision shape before anything comes near it.
#ifndef BT_CCD_SHAPE_OUTLINE_H
#define BT_CCD_SHAPE_OUTLINE_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

#include <optional>

/// As btCcdShapeModel has it. Most objects of most steps are never asked for more.
struct btCcdShapeOutline
{
    double m_reach = 0.0;
    double m_reserve = 0.0;
    double m_depth = 0.0;
    double m_ownMargin = std::numeric_limits<double>::infinity();
    bool m_hasMesh = false;
    bool m_isOwn = false;
};

[[nodiscard]] btCcdShapeOutline btCcdOutlineOf(const btCcdShapeModel& model);

/// The outline straight from the numbers that define the shape; its reach may be larger than the
/// model's. Empty for shapes where only the model can tell: those that are not simple, or not
/// covered. A mesh has an outline even if its triangles turn out to be of no use.
[[nodiscard]] std::optional<btCcdShapeOutline> btCcdSimpleOutline(const btCollisionShape& shape);

#endif  // BT_CCD_SHAPE_OUTLINE_H
