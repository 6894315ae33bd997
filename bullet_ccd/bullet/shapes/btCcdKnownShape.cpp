#include "bullet_ccd/bullet/shapes/btCcdKnownShape.h"

#include "bullet_ccd/bullet/shapes/btCcdShapeContent.h"

#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>

namespace
{
bool isSimpleType(int type)
{
    return type == BOX_SHAPE_PROXYTYPE || type == SPHERE_SHAPE_PROXYTYPE ||
           type == CAPSULE_SHAPE_PROXYTYPE;
}
}  // namespace

btCcdKnownShape::btCcdKnownShape(const btCollisionShape& shape)
    : m_shape(&shape), m_type(shape.getShapeType()), m_isSimple(isSimpleType(m_type))
{
    if (m_isSimple)
    {
        const auto& simple = static_cast<const btConvexInternalShape&>(shape);
        m_dimensions = simple.getImplicitShapeDimensions();
        m_scaling = simple.getLocalScalingNV();
        m_margin = simple.getMarginNV();
        return;
    }
    m_scaling = shape.getLocalScaling();
    m_margin = shape.getMargin();
    m_revision = btCcdRevisionOf(shape);
}

bool btCcdKnownShape::isOther(const btCollisionShape& shape) const
{
    return m_shape == &shape && m_type == shape.getShapeType() &&
           m_scaling == shape.getLocalScaling() && m_margin == shape.getMargin() &&
           m_revision == btCcdRevisionOf(shape);
}
