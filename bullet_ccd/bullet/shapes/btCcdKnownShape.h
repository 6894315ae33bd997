/// Whether a collision shape is still what it was.
#ifndef BT_CCD_KNOWN_SHAPE_H
#define BT_CCD_KNOWN_SHAPE_H

#include "bullet_ccd/bullet/shapes/btCcdGap.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeOutline.h"

#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

/// What there is to know about a shape, while that stays the same.
struct btCcdKnownShape
{
    const btCollisionShape* m_shape = nullptr;
    int m_type = 0;
    bool m_isSimple = false;  // a box, sphere or capsule: its dimensions say all
    btVector3 m_dimensions = btVector3(0, 0, 0);
    btVector3 m_scaling = btVector3(0, 0, 0);
    btScalar m_margin = 0;
    std::uint64_t m_revision = 0;  // see btCcdRevisionOf()
    int m_epoch = -1;              // when it was found to be the same
    bool m_covered = false;
    bool m_isMissed = false;  // it is not covered, or a child is not
    btCcdShapeOutline m_outline;
    btCcdExtent m_extent;
    double m_shell = 0.0;  // kept free around it [m]

    explicit btCcdKnownShape(const btCollisionShape& shape);
    /// Whether this is what there is to know about the shape at the same address.
    [[nodiscard]] bool isOf(const btCollisionShape& shape) const
    {
        return m_isSimple ? isSimpleOne(shape) : isOther(shape);
    }

private:
    /// To the bit, which is cheaper than comparing numbers.
    [[nodiscard]] static bool isSame(btScalar a, btScalar b)
    {
        using Bits = std::conditional_t<sizeof(btScalar) == 8, std::uint64_t, std::uint32_t>;
        return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
    }
    [[nodiscard]] bool isSimpleOne(const btCollisionShape& shape) const
    {
        if (m_type != shape.getShapeType())
        {
            return false;
        }
        // The scaling matters to a sphere only; to the others it is in the dimensions.
        const auto& simple = static_cast<const btConvexInternalShape&>(shape);
        const btVector3& dimensions = simple.getImplicitShapeDimensions();
        return std::memcmp(m_dimensions.m_floats, dimensions.m_floats, 3 * sizeof(btScalar)) == 0 &&
               isSame(m_scaling.x(), simple.getLocalScalingNV().x()) &&
               isSame(m_margin, simple.getMarginNV());
    }
    [[nodiscard]] bool isOther(const btCollisionShape& shape) const;
};

#endif  // BT_CCD_KNOWN_SHAPE_H
