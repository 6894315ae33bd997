/// Hierarchies that are built as far as queries look at them.
///
/// A grid sorts the triangles into cells, and a tree over the cells into blocks of some hundred
/// triangles that are near each other. The nodes of that tree have volumes around the boxes of
/// their cells. Each of its leaves has one child: the root of the hierarchy over the triangles of
/// its block, made as that of a whole mesh once somebody opens the leaf. Where the nodes of a block
/// will stand is known before it is built, so that nothing that is there ever moves or changes.
#pragma once

#include "bullet_ccd/hierarchy/ssv_node.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <oneapi/tbb/collaborative_call_once.h>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// The triangles of a block, and the place of the nodes below it.
struct SsvBlock
{
    std::int32_t begin;  ///< its triangles are in slots begin <= slot < end
    std::int32_t end;
    std::int32_t root;  ///< its nodes are at most 2 (end - begin) - 1, from here on
};

/// A hierarchy of which no block is built.
struct SsvUpperTree
{
    std::vector<SsvNode> nodes;
    std::vector<SsvBlock> blocks;         ///< in the order of their slots, and of their nodes
    std::vector<std::int32_t> triangles;  ///< in the slots; within a block in any order
    double radius = 0.0;                  ///< as SsvTree::radius()
};

/// Sorts the triangles into blocks, on all threads. The result does not depend on their number.
/// @pre checkMesh() passed
[[nodiscard]] SsvUpperTree splitIntoBlocks(const TriangleMesh& mesh, const Eigen::Vector3d& origin);

/// The faces of the mesh, and the slabs of the upper nodes and of the roots of all blocks.
/// @param nodes  how many the tree has room for
[[nodiscard]] FaceSlabs findUpperSlabs(const SsvUpperTree& upper,
                                       const TriangleMesh& mesh,
                                       const Eigen::Vector3d& origin,
                                       std::size_t nodes);

/// The blocks of a tree, and what is needed to build them.
class SsvBlocks
{
public:
    /// The parts of a tree, where they stand in memory; those of blocks that are not built are
    /// not touched.
    struct Parts
    {
        std::span<const Eigen::Vector3d> vertices;  ///< of the mesh, as are the triangles
        std::span<const Triangle> meshTriangles;
        Eigen::Vector3d origin;
        std::span<SsvNode> nodes;
        std::span<SsvSlot> slots;
        std::span<const Eigen::Vector3d> normals;  ///< of FaceSlabs
        std::span<Slab> slabs;
    };

    SsvBlocks(std::vector<SsvBlock> blocks, const Parts& parts);

    /// Builds the block whose nodes begin at `root`, unless that is done. Any number of threads may
    /// call this at the same time; when it returns, they see the nodes.
    void build(std::int32_t root);

    /// Builds all of them, and marks the nodes that no block needed as no nodes of the tree.
    void buildAll();

    /// How many triangles are in blocks that are built.
    [[nodiscard]] std::size_t builtTriangles() const { return m_builtTriangles.load(); }

private:
    void build(std::size_t index);
    void fill(std::size_t index);

    std::vector<SsvBlock> m_blocks;
    Parts m_parts;
    std::vector<std::int32_t> m_used;  ///< nodes, by block
    std::deque<tbb::collaborative_once_flag> m_flags;
    std::atomic<std::size_t> m_builtTriangles = 0;
    std::once_flag m_marked;
};
}  // namespace bullet_ccd
