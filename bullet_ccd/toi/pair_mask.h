/// Triangles of two meshes that are not tested against each other, because two links are joined
/// there or a body rests on another from the start.
#pragma once

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Marks on the triangles of two meshes. A pair of triangles is exempt if both are marked. Unmarked
/// triangles are tested against all others.
class BULLET_CCD_API PairMask
{
public:
    /// @param marksA,marksB one entry per triangle of the mesh; non-zero marks it
    PairMask(const SsvTree& treeA,
             const SsvTree& treeB,
             std::span<const std::uint8_t> marksA,
             std::span<const std::uint8_t> marksB);

    /// True if all triangles below one node are exempt from all below the other.
    [[nodiscard]] bool exemptsNodes(std::int32_t nodeA, std::int32_t nodeB) const
    {
        return m_nodesA[static_cast<std::size_t>(nodeA)] != 0 &&
               m_nodesB[static_cast<std::size_t>(nodeB)] != 0;
    }
    /// True if the two triangles, given by their indices in the meshes, are exempt.
    [[nodiscard]] bool exemptsTriangles(std::int32_t triangleA, std::int32_t triangleB) const
    {
        return m_marksA[static_cast<std::size_t>(triangleA)] != 0 &&
               m_marksB[static_cast<std::size_t>(triangleB)] != 0;
    }
    /// The marks of the nodes, as treeDistance() takes them.
    [[nodiscard]] NodeMarks nodeMarks() const { return {.a = m_nodesA, .b = m_nodesB}; }
    /// True if no pair is exempt.
    [[nodiscard]] bool isEmpty() const { return m_isEmpty; }

private:
    std::vector<std::uint8_t> m_marksA;
    std::vector<std::uint8_t> m_marksB;
    std::vector<std::uint8_t> m_nodesA;
    std::vector<std::uint8_t> m_nodesB;
    bool m_isEmpty = true;
};

/// Marks on both meshes the triangles that are within `reach` [m] of the other mesh at one of the
/// poses. For two joined links, poses over the range of the joint mark the region of the joint, and
/// the rest of both links is still tested.
/// @param posesOfAInB poses X_BA of A's frame in B's
[[nodiscard]] BULLET_CCD_API PairMask maskNear(const SsvTree& treeA,
                                               const SsvTree& treeB,
                                               std::span<const Eigen::Isometry3d> posesOfAInB,
                                               double reach);
}  // namespace bullet_ccd
