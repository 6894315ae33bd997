/// What a collision shape is made of: the parts of meshes, and all of it as a number.
#ifndef BT_CCD_SHAPE_CONTENT_H
#define BT_CCD_SHAPE_CONTENT_H

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

class btCollisionShape;
class btHeightfieldTerrainShape;

/// Hash of a sequence of numbers.
class btCcdHash
{
public:
    [[nodiscard]] std::uint64_t value() const { return m_hash; }

    void addBits(std::uint64_t bits)
    {
        m_hash = (m_hash ^ bits) * 0x9e3779b97f4a7c15U;
        m_hash ^= m_hash >> 32U;
    }
    void add(int number) { addBits(std::uint64_t(std::uint32_t(number))); }
    void add(btScalar number)
    {
        using Bits = std::conditional_t<sizeof(btScalar) == 8, std::uint64_t, std::uint32_t>;
        addBits(std::bit_cast<Bits>(number));
    }
    void add(const void* address) { addBits(std::bit_cast<std::uintptr_t>(address)); }
    void add(const btVector3& v)
    {
        add(v.x());
        add(v.y());
        add(v.z());
    }
    void addBytes(const void* from, std::size_t count);

private:
    std::uint64_t m_hash = 0;
};

/// What a height field keeps to itself.
struct btCcdHeightGrid
{
    int m_width;
    int m_length;
    const void* m_heights;
    PHY_ScalarType m_type;
};
[[nodiscard]] btCcdHeightGrid btCcdHeightGridOf(const btHeightfieldTerrainShape& shape);

/// One part of a mesh interface, as it lies in memory.
struct btCcdMeshPart
{
    const unsigned char* m_vertices = nullptr;
    int m_vertexCount = 0;
    PHY_ScalarType m_vertexType = PHY_FLOAT;
    int m_vertexStride = 0;
    const unsigned char* m_indices = nullptr;
    int m_indexStride = 0;
    int m_triangleCount = 0;
    PHY_ScalarType m_indexType = PHY_INTEGER;
};

/// Calls `visit` with the part, which is locked meanwhile.
template <class Visit>
void btCcdVisitMeshPart(const btStridingMeshInterface& mesh, int part, const Visit& visit)
{
    btCcdMeshPart data;
    mesh.getLockedReadOnlyVertexIndexBase(&data.m_vertices,
                                          data.m_vertexCount,
                                          data.m_vertexType,
                                          data.m_vertexStride,
                                          &data.m_indices,
                                          data.m_indexStride,
                                          data.m_triangleCount,
                                          data.m_indexType,
                                          part);
    visit(data);
    mesh.unLockReadOnlyVertexBase(part);
}

/// Hash of all points, triangles and heights of the shape and of its children. Zero for shapes that
/// have none, or that share an immutable hierarchy.
[[nodiscard]] std::uint64_t btCcdContentOf(const btCollisionShape& shape);

/// Hash of what tells soon that the content has changed: addresses, counts and a sample. Zero for
/// shapes without points or heights.
[[nodiscard]] std::uint64_t btCcdRevisionOf(const btCollisionShape& shape);

#endif  // BT_CCD_SHAPE_CONTENT_H
