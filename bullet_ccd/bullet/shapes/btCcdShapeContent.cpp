#include "bullet_ccd/bullet/shapes/btCcdShapeContent.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <cstring>

namespace
{
/// The fields of a height field are open to derived classes only.
struct HeightField : btHeightfieldTerrainShape
{
    static btCcdHeightGrid gridOf(const btHeightfieldTerrainShape& shape)
    {
        return {shape.*(&HeightField::m_heightStickWidth),
                shape.*(&HeightField::m_heightStickLength),
                shape.*(&HeightField::m_heightfieldDataUnknown),
                shape.*(&HeightField::m_heightDataType)};
    }
    static btScalar heightOf(const btHeightfieldTerrainShape& shape, int x, int y)
    {
        return (shape.*(&HeightField::getRawHeightFieldValue))(x, y);
    }
};

std::size_t sizeOf(PHY_ScalarType type)
{
    switch (type)
    {
        case PHY_DOUBLE:
            return sizeof(double);
        case PHY_SHORT:
            return sizeof(short);
        case PHY_UCHAR:
            return sizeof(unsigned char);
        default:
            return sizeof(float);
    }
}

void addHeights(btCcdHash& hash, const btHeightfieldTerrainShape& shape)
{
    const btCcdHeightGrid grid = btCcdHeightGridOf(shape);
    hash.add(grid.m_width);
    hash.add(grid.m_length);
    const std::size_t size = sizeOf(grid.m_type);
    hash.addBytes(grid.m_heights, size * std::size_t(grid.m_width) * std::size_t(grid.m_length));
}

/// `count` rows of which only the first `used` bytes matter.
void addRows(btCcdHash& hash, const unsigned char* from, int count, int stride, std::size_t used)
{
    for (int i = 0; i < count; ++i)
    {
        hash.addBytes(from + std::ptrdiff_t(i) * stride, used);
    }
}

void addTriangles(btCcdHash& hash, const btStridingMeshInterface& mesh)
{
    for (int part = 0; part < mesh.getNumSubParts(); ++part)
    {
        btCcdVisitMeshPart(
            mesh,
            part,
            [&hash](const btCcdMeshPart& data)
            {
                const std::size_t index =
                    data.m_indexType == PHY_INTEGER ? sizeof(int) : sizeOf(data.m_indexType);
                addRows(hash,
                        data.m_vertices,
                        data.m_vertexCount,
                        data.m_vertexStride,
                        3 * sizeOf(data.m_vertexType));
                addRows(hash, data.m_indices, data.m_triangleCount, data.m_indexStride, 3 * index);
            });
    }
}

void addContent(btCcdHash& hash, const btCollisionShape& shape);

void addGImpactParts(btCcdHash& hash, const btGImpactShapeInterface& shape)
{
    if (shape.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE)
    {
        const auto& mesh = static_cast<const btGImpactMeshShape&>(shape);
        if (mesh.getMeshInterface() != nullptr)
        {
            addTriangles(hash, *mesh.getMeshInterface());
        }
    }
}

void addContent(btCcdHash& hash, const btCollisionShape& shape)
{
    switch (shape.getShapeType())
    {
        case CONVEX_HULL_SHAPE_PROXYTYPE:
        {
            const auto& hull = static_cast<const btConvexHullShape&>(shape);
            for (int i = 0; i < hull.getNumPoints(); ++i)
            {
                hash.add(hull.getUnscaledPoints()[i]);
            }
            break;
        }
        case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
            addTriangles(hash,
                         *static_cast<const btConvexTriangleMeshShape&>(shape).getMeshInterface());
            break;
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
            addTriangles(hash,
                         *static_cast<const btBvhTriangleMeshShape&>(shape).getMeshInterface());
            break;
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
            addTriangles(hash,
                         *static_cast<const btScaledBvhTriangleMeshShape&>(shape)
                              .getChildShape()
                              ->getMeshInterface());
            break;
        case TERRAIN_SHAPE_PROXYTYPE:
            addHeights(hash, static_cast<const btHeightfieldTerrainShape&>(shape));
            break;
        case GIMPACT_SHAPE_PROXYTYPE:
            addGImpactParts(hash, static_cast<const btGImpactShapeInterface&>(shape));
            break;
        case COMPOUND_SHAPE_PROXYTYPE:
        {
            const auto& compound = static_cast<const btCompoundShape&>(shape);
            for (int i = 0; i < compound.getNumChildShapes(); ++i)
            {
                addContent(hash, *compound.getChildShape(i));
            }
            break;
        }
        default:
            break;
    }
}
}  // namespace

void btCcdHash::addBytes(const void* from, std::size_t count)
{
    const auto* bytes = static_cast<const unsigned char*>(from);
    std::uint64_t word = 0;
    for (; count >= sizeof(word); bytes += sizeof(word), count -= sizeof(word))
    {
        std::memcpy(&word, bytes, sizeof(word));
        addBits(word);
    }
    word = 0;
    std::memcpy(&word, bytes, count);
    addBits(word);
}

btCcdHeightGrid btCcdHeightGridOf(const btHeightfieldTerrainShape& shape)
{
    return HeightField::gridOf(shape);
}

std::uint64_t btCcdContentOf(const btCollisionShape& shape)
{
    btCcdHash hash;
    addContent(hash, shape);
    return hash.value();
}

std::uint64_t btCcdRevisionOf(const btCollisionShape& shape)
{
    btCcdHash hash;
    if (shape.getShapeType() == CONVEX_HULL_SHAPE_PROXYTYPE)
    {
        const auto& hull = static_cast<const btConvexHullShape&>(shape);
        const int count = hull.getNumPoints();
        hash.add(count);
        if (count > 0)
        {
            const btVector3* points = hull.getUnscaledPoints();
            hash.add(points);
            hash.add(points[0]);
            hash.add(points[count / 2]);
            hash.add(points[count - 1]);
        }
    }
    else if (shape.getShapeType() == TERRAIN_SHAPE_PROXYTYPE)
    {
        constexpr int kSamples = 4;  // a side
        const auto& terrain = static_cast<const btHeightfieldTerrainShape&>(shape);
        const btCcdHeightGrid grid = btCcdHeightGridOf(terrain);
        hash.add(grid.m_width);
        hash.add(grid.m_length);
        hash.add(grid.m_heights);
        for (int i = 0; i < kSamples * kSamples; ++i)
        {
            const int x = (grid.m_width - 1) * (i % kSamples) / (kSamples - 1);
            const int y = (grid.m_length - 1) * (i / kSamples) / (kSamples - 1);
            hash.add(HeightField::heightOf(terrain, x, y));
        }
    }
    else if (shape.isCompound())
    {
        hash.add(static_cast<const btCompoundShape&>(shape).getUpdateRevision());
    }
    return hash.value();
}
