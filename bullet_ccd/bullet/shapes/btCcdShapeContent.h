/// What a collision shape is made of, as a number.
#ifndef BT_CCD_SHAPE_CONTENT_H
#define BT_CCD_SHAPE_CONTENT_H

#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <cstdint>

class btCollisionShape;
class btHeightfieldTerrainShape;

/// What a height field keeps to itself.
struct btCcdHeightGrid
{
    int m_width;
    int m_length;
    const void* m_heights;
    PHY_ScalarType m_type;
};
[[nodiscard]] btCcdHeightGrid btCcdHeightGridOf(const btHeightfieldTerrainShape& shape);

/// Hash of all points, triangles and heights of the shape and of its children. Zero for shapes that
/// have none, or that share an immutable hierarchy.
[[nodiscard]] std::uint64_t btCcdContentOf(const btCollisionShape& shape);

/// Hash of what tells soon that the content has changed: addresses, counts and a sample. Zero for
/// shapes without points or heights.
[[nodiscard]] std::uint64_t btCcdRevisionOf(const btCollisionShape& shape);

#endif  // BT_CCD_SHAPE_CONTENT_H
