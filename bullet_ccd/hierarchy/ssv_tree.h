/// Bounding-volume hierarchy of a triangle mesh, built once and shared by all queries.
///
/// Every node holds a swept-sphere volume: a box that is swept by a ball. The size of the ball is
/// chosen so that the volume has little surface, and may be zero. Nodes stand in one array, and up
/// to four siblings are adjacent. A node has 64 bytes in single precision, rounded outwards.
/// Triangles keep their vertices in double precision.
///
/// ssv_split orders the triangles and decides which are below which node. ssv_fit encloses the
/// triangles of every node. ssv_tree puts the two together, and refit() repeats the fit only.
/// face_slabs knows the flat faces. ssv_tree_file keeps the result on disk.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_node.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd
{
class SsvBlocks;

/// Largest number of children of a node.
constexpr std::int32_t kArity = 4;

/// Memory of plain values that is not touched before they are written: what of a large array is
/// never used costs nothing.
template <class T>
struct UntouchedMemory : std::allocator<T>
{
    template <class U>
    struct rebind
    {
        using other = UntouchedMemory<U>;
    };
    template <class U, class... Arguments>
    void construct(U* at, Arguments&&... arguments)
    {
        if constexpr (sizeof...(Arguments) > 0)
        {
            ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
        }
    }
};
template <class T>
using UntouchedVector = std::vector<T, UntouchedMemory<T>>;

/// low <= n.x <= high for all points x of some triangles along a unit direction n [m].
struct Slab
{
    double low;
    double high;
};

/// The normals of the largest faces, and how far every node of a hierarchy reaches along them, in
/// double precision: volumes in single precision blur it, and where flat lies on flat nothing else
/// decides.
///
/// Guarantee: slabs are exact up to a few roundings of double precision. A normal belongs to at
/// least kLeastTriangles triangles of a sample of the mesh; a curved mesh has none.
struct FaceSlabs
{
    static constexpr std::size_t kMostNormals = 3;
    static constexpr std::int32_t kLeastTriangles = 8;

    std::vector<Eigen::Vector3d> normals{};  ///< unit, in the frame of the tree
    UntouchedVector<Slab> slabs{};           ///< for every node one along every normal

    [[nodiscard]] bool empty() const { return normals.empty(); }
    [[nodiscard]] std::span<const Slab> ofNode(std::int32_t node) const
    {
        return std::span(slabs).subspan(static_cast<std::size_t>(node) * normals.size(),
                                        normals.size());
    }
};

/// Which triangle of the mesh is in a slot, and with which corner it begins: the smallest, so that
/// how a file lists them changes nothing.
struct SsvSlot
{
    std::uint32_t triangle : 30;
    std::uint32_t first : 2;
};

/// What builds the rest of a tree that is built as far as it is looked at. A copy of the tree is
/// built to the end, and has none.
class BULLET_CCD_API SsvBlocksOwner
{
public:
    SsvBlocksOwner();
    explicit SsvBlocksOwner(std::unique_ptr<SsvBlocks> blocks);
    /// Builds the rest of the tree that is copied, before its other parts are copied.
    SsvBlocksOwner(const SsvBlocksOwner& other);
    SsvBlocksOwner& operator=(const SsvBlocksOwner& other);
    SsvBlocksOwner(SsvBlocksOwner&&) noexcept;
    SsvBlocksOwner& operator=(SsvBlocksOwner&&) noexcept;
    ~SsvBlocksOwner();

    [[nodiscard]] SsvBlocks* get() const { return m_blocks.get(); }

private:
    std::unique_ptr<SsvBlocks> m_blocks;
};

/// Hierarchy over a mesh, of which it keeps its own copy. Only refit() changes it.
class BULLET_CCD_API SsvTree
{
public:
    /// All nodes; there is at least one. Node 0 is the root, and children come after their parent.
    ///
    /// Of a tree of buildSsvTreeAsNeeded(), a node with one child is a door: the child, and what is
    /// below, is there once open() has been called with it.
    [[nodiscard]] std::span<const SsvNode> nodes() const { return m_nodes; }
    /// To be called before the children of a node, or anything below them, are looked at. Any
    /// number of threads may do so.
    void open(const SsvNode& node) const
    {
        if (node.count == 1) [[unlikely]]
        {
            buildBelow(node);
        }
    }
    /// Opens all nodes. Nodes whose `first` is kNone then belong to no tree.
    void openAll() const;
    /// How many triangles are below no door that has not been opened.
    [[nodiscard]] std::size_t builtTriangles() const;
    [[nodiscard]] const TriangleMesh& mesh() const { return m_mesh; }
    /// Origin of the tree's frame in the mesh's [m]. It is the middle of the bounds, so that single
    /// precision is spent on the size of the mesh and not on its place.
    [[nodiscard]] const Eigen::Vector3d& origin() const { return m_origin; }
    /// The three corners of the triangle in a leaf's slot, in the tree's frame [m]. Slots are in
    /// the order of the leaves.
    [[nodiscard]] std::array<Eigen::Vector3d, 3> corners(std::int32_t slot) const
    {
        const SsvSlot here = m_slots[static_cast<std::size_t>(slot)];
        const Triangle& triangle = m_mesh.triangles[here.triangle];
        const auto corner = [&](std::size_t k) -> Eigen::Vector3d
        { return m_mesh.vertices[static_cast<std::size_t>(triangle[k])] - m_origin; };
        constexpr std::size_t kNext[] = {0, 1, 2, 0, 1};
        return {corner(here.first), corner(kNext[here.first + 1]), corner(kNext[here.first + 2])};
    }
    /// The three corners of a triangle of mesh(), in the tree's frame [m].
    [[nodiscard]] std::array<Eigen::Vector3d, 3> cornersOfTriangle(std::int32_t triangle) const;
    /// Index in mesh() of the triangle in a slot.
    [[nodiscard]] std::int32_t triangle(std::int32_t slot) const
    {
        return static_cast<std::int32_t>(m_slots[static_cast<std::size_t>(slot)].triangle);
    }
    /// Largest distance of a vertex of a triangle from origin() [m].
    [[nodiscard]] double radius() const { return m_radius; }
    /// Where the largest flat faces are.
    [[nodiscard]] const FaceSlabs& faceSlabs() const { return m_faces; }

    /// Moves the vertices of mesh() to `vertices` (mesh frame [m]) and fits every volume anew.
    ///
    /// Guarantee: the same triangles stay below the same nodes, and every volume is as tight as one
    /// that is built for the same triangles. Queries stay right for any deformation, but they slow
    /// down where triangles that were neighbours part. origin() moves along.
    /// Throws std::invalid_argument, and changes nothing, if the number of vertices differs or one
    /// of them is not finite.
    void refit(std::span<const Eigen::Vector3d> vertices);

    friend SsvTree buildSsvTree(TriangleMesh mesh);
    friend SsvTree buildSsvTreeAsNeeded(TriangleMesh mesh);
    friend SsvTree loadSsvTree(TriangleMesh mesh, const std::filesystem::path& path);

private:
    explicit SsvTree(TriangleMesh mesh);
    std::vector<std::array<Eigen::Vector3d, 3>> place(std::span<const std::int32_t> triangles);
    void buildBelow(const SsvNode& node) const;

    SsvBlocksOwner m_blocks;  ///< the first, see there
    TriangleMesh m_mesh;
    UntouchedVector<SsvNode> m_nodes;
    std::vector<SsvSlot> m_slots;
    FaceSlabs m_faces;
    Eigen::Vector3d m_origin = Eigen::Vector3d::Zero();
    double m_radius = 0.0;
};

/// Builds the hierarchy top-down with one triangle per leaf, in O(n log n). Large meshes take all
/// threads.
///
/// Guarantee: the result does not depend on the number of threads.
/// Throws std::invalid_argument if the mesh is empty, has indices out of range, or has coordinates
/// that are not finite (see checkMesh()).
[[nodiscard]] BULLET_CCD_API SsvTree buildSsvTree(TriangleMesh mesh);

/// The same for a mesh of which few queries will see a small part: only the top is built, and the
/// rest block by block of some hundred triangles when a query first comes there (SsvTree::open()).
/// Memory likewise. Meshes of fewer than kLeastAsNeeded triangles are built at once.
///
/// Guarantee: the tree does not depend on the order of the queries, nor on the number of threads.
/// It is another one than that of buildSsvTree(); answers keep the same promises.
/// Throws as buildSsvTree().
[[nodiscard]] BULLET_CCD_API SsvTree buildSsvTreeAsNeeded(TriangleMesh mesh);
constexpr std::size_t kLeastAsNeeded = 8192;

// Hierarchies on disk, so that a large mesh is ready in milliseconds.
//
// A file holds the nodes and the order of the triangles, but not the mesh. The caller gives the
// mesh when the file is loaded, and its content hash says whether the file belongs to it. A file is
// accepted only if magic, version, volumes, mesh, sizes and checksum are right, and if its indices
// describe a tree over exactly the triangles of the mesh. So no file can make a query read out of
// bounds. The numbers in it are little-endian.

/// Writes a temporary file beside `path` and renames it.
///
/// What is not built of the tree is built first, and doors are left out.
///
/// Guarantee: whoever reads or writes the same file at the same time sees a complete one.
/// Throws std::runtime_error "<path>: <what>: <remedy>".
BULLET_CCD_API void saveSsvTree(const SsvTree& tree, const std::filesystem::path& path);

/// Loads the hierarchy of `mesh`.
///
/// Guarantee: the result has the same bits that buildSsvTree(mesh) gave where it was saved, if it
/// was that tree that was saved.
/// Throws std::runtime_error "<path>: <what>: <remedy>" for a file that is missing, truncated,
/// damaged, no hierarchy, or of another version, mesh or kind of volumes. Throws
/// std::invalid_argument for a mesh that buildSsvTree() would refuse.
[[nodiscard]] BULLET_CCD_API SsvTree loadSsvTree(TriangleMesh mesh,
                                                 const std::filesystem::path& path);

/// Name of the file that loadOrBuildSsvTree() keeps for a mesh. It depends on the content of the
/// mesh.
[[nodiscard]] BULLET_CCD_API std::filesystem::path ssvTreeFileName(const TriangleMesh& mesh);

/// Loads the hierarchy from the folder if a right file is there; otherwise builds and saves it. The
/// folder is made if it does not exist. If it cannot be written, the hierarchy is not saved, and
/// that is no error.
/// Throws std::invalid_argument as buildSsvTree() does.
[[nodiscard]] BULLET_CCD_API SsvTree loadOrBuildSsvTree(TriangleMesh mesh,
                                                        const std::filesystem::path& cacheFolder);
}  // namespace bullet_ccd
