/// How far apart two shapes are at least.
#ifndef BT_CCD_GAP_H
#define BT_CCD_GAP_H

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <LinearMath/btTransform.h>

/// A box about a shape, in its frame; of a plane, the half space below it.
struct btCcdExtent
{
    btVector3 m_center = btVector3(0, 0, 0);
    btVector3 m_half = btVector3(0, 0, 0);    ///< may be infinite
    btVector3 m_normal = btVector3(0, 0, 0);  ///< of a plane; zero for all others
    btScalar m_offset = 0;                    ///< the plane is normal * x = offset
};

[[nodiscard]] btCcdExtent btCcdExtentOf(const btCollisionShape& shape);

/// True for a rotation, as far as Bullet keeps one. A program may have put a scale into it.
[[nodiscard]] bool btCcdIsRotation(const btMatrix3x3& basis);

/// Lower bound of the distance of two shapes [m]; negative if there is none, or a pose is no
/// rotation. What is above `enough` need not be the best bound.
[[nodiscard]] double btCcdGap(const btCcdExtent& a,
                              const btTransform& poseA,
                              const btCcdExtent& b,
                              const btTransform& poseB,
                              double enough = BT_INFINITY);

#endif  // BT_CCD_GAP_H
