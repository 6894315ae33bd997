#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeContent.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <LinearMath/btSerializer.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

// A .bullet file has no chunk for shapes that Bullet does not know. A static triangle mesh has room
// for vertices in double precision in files of either precision, but only for a margin and a
// scaling in single precision. So three vertices follow that no triangle uses: a mark, the margin,
// and the scaling. Loaders make bodies static that have a static mesh. So ours gets a stand-in that
// may move, until the file has been read.

namespace
{
constexpr std::size_t kExtra = 3;
constexpr std::array kMark{-0x1.ccd3a9b1c05p-900, 0x1.5ca1ab1ep-911, -0x1.0b1dea7edp-922};

template <typename T>
T* chunkOf(btSerializer& serializer, std::size_t count, btChunk*& chunk)
{
    chunk = serializer.allocate(sizeof(T), int(count));
    std::memset(chunk->m_oldPtr, 0, count * sizeof(T));
    return static_cast<T*>(chunk->m_oldPtr);
}

void write(const Eigen::Vector3d& from, btVector3DoubleData& to)
{
    for (int k = 0; k < 3; ++k)
    {
        to.m_floats[k] = from[k];
    }
}

/// A number or an index, wherever it lies.
template <typename T>
T readAt(const unsigned char* place)
{
    T value;
    std::memcpy(&value, place, sizeof(T));
    return value;
}

/// @pre the vertices are in double precision
void append(const btCcdMeshPart& part, bullet_ccd::TriangleMesh& mesh)
{
    for (int i = 0; i < part.m_vertexCount; ++i)
    {
        const unsigned char* vertex =
            part.m_vertices + std::ptrdiff_t(i) * std::ptrdiff_t(part.m_vertexStride);
        mesh.vertices.emplace_back(
            readAt<double>(vertex), readAt<double>(vertex + 8), readAt<double>(vertex + 16));
    }
    for (int i = 0; i < part.m_triangleCount; ++i)
    {
        const unsigned char* triangle =
            part.m_indices + std::ptrdiff_t(i) * std::ptrdiff_t(part.m_indexStride);
        const auto corner = [&](std::size_t k)
        {
            switch (part.m_indexType)
            {
                case PHY_SHORT:
                    return std::int32_t(readAt<std::uint16_t>(triangle + 2 * k));
                case PHY_UCHAR:
                    return std::int32_t(triangle[k]);
                default:
                    return readAt<std::int32_t>(triangle + 4 * k);
            }
        };
        mesh.triangles.push_back({corner(0), corner(1), corner(2)});
    }
}

/// A mesh that was saved, as its three vertices have it.
struct Saved
{
    bullet_ccd::TriangleMesh m_mesh;
    btScalar m_margin = 0;
    btVector3 m_scaling = btVector3(1, 1, 1);
};

std::optional<Saved> readSaved(const btStridingMeshInterface& interface)
{
    Saved saved;
    if (interface.getNumSubParts() != 1)
    {
        return std::nullopt;
    }
    bool isDouble = false;
    btCcdVisitMeshPart(interface,
                       0,
                       [&](const btCcdMeshPart& part)
                       {
                           isDouble = part.m_vertexType == PHY_DOUBLE;
                           if (isDouble)
                           {
                               append(part, saved.m_mesh);
                           }
                       });
    std::vector<Eigen::Vector3d>& vertices = saved.m_mesh.vertices;
    const std::size_t count = vertices.size();
    if (!isDouble || count <= kExtra ||
        vertices[count - kExtra] != Eigen::Vector3d(kMark[0], kMark[1], kMark[2]))
    {
        return std::nullopt;
    }
    saved.m_margin = btScalar(vertices[count - 2].x());
    saved.m_scaling = btCcdToBullet(vertices[count - 1]);
    vertices.resize(count - kExtra);
    return saved;
}

/// Stands for a mesh while a file is read. Its type is one that may move, and nobody asks it for
/// more than a box and its inertia before restoreMeshes().
class StandIn : public btBvhTriangleMeshShape
{
public:
    StandIn(btStridingMeshInterface* interface, std::shared_ptr<btCcdMeshShape> mesh)
        : btBvhTriangleMeshShape(interface, true, false), m_mesh(std::move(mesh))
    {
        m_shapeType = GIMPACT_SHAPE_PROXYTYPE;
    }
    void calculateLocalInertia(btScalar mass, btVector3& inertia) const override
    {
        m_mesh->calculateLocalInertia(mass, inertia);
    }
    [[nodiscard]] const std::shared_ptr<btCcdMeshShape>& mesh() const { return m_mesh; }

private:
    std::shared_ptr<btCcdMeshShape> m_mesh;
};

using Meshes = std::vector<std::shared_ptr<btCcdMeshShape>>;

/// The mesh that the shape stands for, or null.
btCcdMeshShape* restored(const btCollisionShape* shape, Meshes& meshes)
{
    const auto* standIn = dynamic_cast<const StandIn*>(shape);
    if (standIn == nullptr)
    {
        return nullptr;
    }
    if (std::find(meshes.begin(), meshes.end(), standIn->mesh()) == meshes.end())
    {
        meshes.push_back(standIn->mesh());
    }
    return standIn->mesh().get();
}

void restoreChildren(btCollisionShape& shape, Meshes& meshes)
{
    if (!shape.isCompound())
    {
        return;
    }
    auto& compound = static_cast<btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
    {
        btCompoundShapeChild& child = compound.getChildList()[i];
        if (btCcdMeshShape* mesh = restored(child.m_childShape, meshes))
        {
            child.m_childShape = mesh;
            child.m_childShapeType = mesh->getShapeType();
            child.m_childMargin = mesh->getMargin();
            compound.updateChildTransform(i, btTransform(child.m_transform));
        }
        else
        {
            restoreChildren(*child.m_childShape, meshes);
        }
    }
}
}  // namespace

int btCcdMeshShape::calculateSerializeBufferSize() const
{
    return int(sizeof(btTriangleMeshShapeData));
}

const char* btCcdMeshShape::serialize(void* dataBuffer, btSerializer* serializer) const
{
    auto* data = static_cast<btTriangleMeshShapeData*>(dataBuffer);
    std::memset(static_cast<void*>(data), 0, sizeof(*data));
    (void)btConcaveShape::serialize(&data->m_collisionShapeData, serializer);
    data->m_collisionShapeData.m_shapeType = TRIANGLE_MESH_SHAPE_PROXYTYPE;
    data->m_collisionMargin = float(m_collisionMargin);

    const bullet_ccd::TriangleMesh& mesh = m_tree->mesh();
    btChunk* partChunk = nullptr;
    auto* part = chunkOf<btMeshPartData>(*serializer, 1, partChunk);
    data->m_meshInterface.m_numMeshParts = 1;
    data->m_meshInterface.m_meshPartsPtr =
        static_cast<btMeshPartData*>(serializer->getUniquePointer(part));
    m_scaling.serializeFloat(data->m_meshInterface.m_scaling);
    part->m_numTriangles = int(mesh.triangles.size());
    part->m_numVertices = int(mesh.vertices.size() + kExtra);

    btChunk* chunk = nullptr;
    auto* indices = chunkOf<btIntIndexData>(*serializer, 3 * mesh.triangles.size(), chunk);
    part->m_indices32 = static_cast<btIntIndexData*>(serializer->getUniquePointer(indices));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            indices[3 * i + k].m_value = mesh.triangles[i][k];
        }
    }
    serializer->finalizeChunk(chunk, "btIntIndexData", BT_ARRAY_CODE, indices);

    auto* vertices =
        chunkOf<btVector3DoubleData>(*serializer, mesh.vertices.size() + kExtra, chunk);
    part->m_vertices3d = static_cast<btVector3DoubleData*>(serializer->getUniquePointer(vertices));
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        write(vertex, *vertices++);
    }
    write({kMark[0], kMark[1], kMark[2]}, *vertices++);
    write({double(m_collisionMargin), 0.0, 0.0}, *vertices++);
    write(btCcdToEigen(m_scaling), *vertices++);
    serializer->finalizeChunk(chunk, "btVector3DoubleData", BT_ARRAY_CODE, chunk->m_oldPtr);
    serializer->finalizeChunk(partChunk, "btMeshPartData", BT_ARRAY_CODE, part);
    return "btTriangleMeshShapeData";
}

std::unique_ptr<btCcdMeshShape> btCcdMeshShape::fromSaved(const btStridingMeshInterface* mesh)
{
    std::optional<Saved> saved = mesh != nullptr ? readSaved(*mesh) : std::nullopt;
    if (!saved)
    {
        return nullptr;
    }
    std::unique_ptr<btCcdMeshShape> shape = fromMesh(std::move(saved->m_mesh), saved->m_margin);
    shape->setLocalScaling(saved->m_scaling);
    return shape;
}

btBvhTriangleMeshShape* btCcdStandInForSaved(btStridingMeshInterface* mesh)
{
    try
    {
        std::shared_ptr<btCcdMeshShape> shape = btCcdMeshShape::fromSaved(mesh);
        return shape != nullptr ? new StandIn(mesh, std::move(shape)) : nullptr;
    }
    catch (const std::invalid_argument& error)
    {
        std::fprintf(stderr,
                     "bullet_ccd: a saved mesh is damaged (%s); it stays a static triangle mesh\n",
                     error.what());
        return nullptr;
    }
}

std::vector<std::shared_ptr<btCcdMeshShape>> btCcdRestoreMeshes(btCollisionWorld& world)
{
    Meshes meshes;
    btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        btCollisionObject& object = *objects[i];
        if (btCcdMeshShape* mesh = restored(object.getCollisionShape(), meshes))
        {
            object.setCollisionShape(mesh);
        }
        else
        {
            restoreChildren(*object.getCollisionShape(), meshes);
        }
    }
    return meshes;
}
