/// Which triangles are below which node: the topology of a hierarchy, before it has volumes.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// A node without a volume: its children, and the slots of the triangles below it.
struct SsvBranch
{
    std::int32_t first;  ///< as in SsvNode
    std::int32_t count;
    std::int32_t begin;  ///< triangles in slots begin <= slot < end are below the node
    std::int32_t end;
};

struct SsvTopology
{
    std::vector<SsvBranch> branches;      ///< 0 is the root; children after their parent
    std::vector<std::int32_t> triangles;  ///< index of the triangle in each slot
};

/// Node of a binary tree over triangles [begin, end); children adjacent.
struct SsvBinaryNode
{
    std::int32_t begin;
    std::int32_t end;
    std::int32_t first;  ///< 0 for a leaf
    float surface;       ///< of a box, in any unit; not known for the root and for leaves

    [[nodiscard]] bool isLeaf() const { return first == 0; }
};

/// The tree with up to kArity children a node that a binary tree with its root first stands for.
[[nodiscard]] std::vector<SsvBranch> flattened(std::span<const SsvBinaryNode> binary);

/// Splits the triangles top-down until every leaf has one.
/// @pre checkMesh() passed
[[nodiscard]] SsvTopology splitTriangles(const TriangleMesh& mesh, const Eigen::Vector3d& origin);

/// Index of the lexicographically smallest corner of a triangle, the first of equal ones.
template <class Corners>
[[nodiscard]] std::size_t smallestOf(const Corners& corners)
{
    const auto smaller = [](const auto& a, const auto& b)
    { return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3); };
    return static_cast<std::size_t>(
        std::min_element(std::begin(corners), std::end(corners), smaller) - std::begin(corners));
}

constexpr std::uint32_t kMostSsvTriangles = (1U << 30U) - 1U;  ///< that slots can name

[[nodiscard]] inline SsvSlot slotOf(std::int32_t triangle, std::size_t firstCorner)
{
    SsvSlot slot{};
    slot.triangle = static_cast<std::uint32_t>(triangle) & kMostSsvTriangles;
    slot.first = firstCorner & 3U;
    return slot;
}

/// Rotates the corners of a triangle so that the smallest is first. The tree sees triangles so, and
/// sorted, so that how a file lists them changes nothing.
template <class Corners>
void rotateToSmallest(Corners& corners)
{
    std::rotate(std::begin(corners),
                std::begin(corners) + static_cast<std::ptrdiff_t>(smallestOf(corners)),
                std::end(corners));
}
}  // namespace bullet_ccd
