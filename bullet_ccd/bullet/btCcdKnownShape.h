/// Whether a collision shape is still what it was.
#ifndef BT_CCD_KNOWN_SHAPE_H
#define BT_CCD_KNOWN_SHAPE_H

#include "bullet_ccd/bullet/btCcdGap.h"
#include "bullet_ccd/bullet/btCcdShapeOutline.h"

#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>

/// What there is to know about a shape, while that stays the same.
struct btCcdKnownShape
{
    const btCollisionShape* m_shape = nullptr;
    int m_type = 0;
    bool m_isSimple = false;  // a box, sphere or capsule: its dimensions say all
    btVector3 m_dimensions = btVector3(0, 0, 0);
    btVector3 m_scaling = btVector3(0, 0, 0);
    btScalar m_margin = 0;
    int m_revision = 0;  // of a compound
    int m_epoch = -1;    // when it was found to be the same
    bool m_covered = false;
    btCcdShapeOutline m_outline;
    btCcdExtent m_extent;
    double m_shell = 0.0;  // kept free around it [m]

    explicit btCcdKnownShape(const btCollisionShape& shape);
    [[nodiscard]] bool isOf(const btCollisionShape& shape) const
    {
        return m_isSimple ? isSimpleOne(shape) : isOther(shape);
    }

private:
    [[nodiscard]] bool isSimpleOne(const btCollisionShape& shape) const
    {
        if (m_shape != &shape || m_type != shape.getShapeType())
        {
            return false;
        }
        // The scaling matters to a sphere only; to the others it is in the dimensions.
        const auto& simple = static_cast<const btConvexInternalShape&>(shape);
        const btVector3& dimensions = simple.getImplicitShapeDimensions();
        return m_dimensions.x() == dimensions.x() && m_dimensions.y() == dimensions.y() &&
               m_dimensions.z() == dimensions.z() &&
               m_scaling.x() == simple.getLocalScalingNV().x() && m_margin == simple.getMarginNV();
    }
    [[nodiscard]] bool isOther(const btCollisionShape& shape) const;
};

#endif  // BT_CCD_KNOWN_SHAPE_H
