#include "bullet_ccd/bullet/shapes/btCcdShapeOutline.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <cmath>

namespace
{
/// Of a convex shape whose planes are `inner` from its middle.
std::optional<btCcdShapeOutline> convexOutline(double reach, double inner)
{
    if (!(inner > 0.0) || !std::isfinite(reach))
    {
        return std::nullopt;
    }
    btCcdShapeOutline outline;
    outline.m_reach = reach;
    outline.m_depth = outline.m_reserve = btCcdCoreDepth(inner);
    return outline;
}

std::optional<btCcdShapeOutline> meshOutline(const btCollisionShape& shape)
{
    btVector3 low;
    btVector3 high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    btCcdShapeOutline outline;
    outline.m_hasMesh = true;
    outline.m_reserve = btCcdShareOfMargin * double(shape.getMargin());
    outline.m_reach = btCcdToEigen(low).cwiseAbs().cwiseMax(btCcdToEigen(high).cwiseAbs()).norm();
    return std::isfinite(outline.m_reach) ? std::optional(outline) : std::nullopt;
}

std::optional<btCcdShapeOutline> compoundOutline(const btCompoundShape& compound)
{
    if (compound.getNumChildShapes() == 0)
    {
        return std::nullopt;
    }
    btCcdShapeOutline sum;
    sum.m_reserve = sum.m_depth = std::numeric_limits<double>::infinity();
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
    {
        const auto child = btCcdSimpleOutline(*compound.getChildShape(i));
        if (!child)
        {
            return std::nullopt;
        }
        const double offset = double(compound.getChildTransform(i).getOrigin().length());
        sum.m_reach = std::max(sum.m_reach, offset + child->m_reach);
        sum.m_reserve = std::min(sum.m_reserve, child->m_reserve);
        sum.m_depth = std::min(sum.m_depth, child->m_depth);
        sum.m_hasMesh = sum.m_hasMesh || child->m_hasMesh;
    }
    return sum;
}
}  // namespace

btCcdShapeOutline btCcdOutlineOf(const btCcdShapeModel& model)
{
    return {model.m_reach,
            model.m_reserve,
            model.m_depth,
            model.m_ownMargin,
            model.m_hasMesh,
            model.m_isOwn};
}

std::optional<btCcdShapeOutline> btCcdSimpleOutline(const btCollisionShape& shape)
{
    switch (shape.getShapeType())
    {
        case BOX_SHAPE_PROXYTYPE:
        {
            const Eigen::Vector3d half =
                btCcdToEigen(static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin());
            return convexOutline(half.norm(), half.minCoeff());
        }
        case SPHERE_SHAPE_PROXYTYPE:
        {
            const double radius = double(static_cast<const btSphereShape&>(shape).getRadius());
            return convexOutline(radius, radius);
        }
        case CAPSULE_SHAPE_PROXYTYPE:
        {
            const auto& capsule = static_cast<const btCapsuleShape&>(shape);
            const double radius = double(capsule.getRadius());
            return convexOutline(radius + std::abs(double(capsule.getHalfHeight())), radius);
        }
        case STATIC_PLANE_PROXYTYPE:
        {
            btCcdShapeOutline outline;
            outline.m_reach = btCcdPlaneReach;
            outline.m_hasMesh = true;
            return outline;
        }
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case TERRAIN_SHAPE_PROXYTYPE:
            return meshOutline(shape);
        case COMPOUND_SHAPE_PROXYTYPE:
            return compoundOutline(static_cast<const btCompoundShape&>(shape));
        default:
            return std::nullopt;
    }
}
