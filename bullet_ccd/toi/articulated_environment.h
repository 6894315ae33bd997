/// The surroundings of an articulated body: a tree of boxes over objects, built once for any number
/// of queries.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Objects that rest or move as RigidBody says, over t in [0, 1]. Hierarchies and motions supplied
/// by the user are referred to and not copied. They must outlive the environment and must not
/// change while it is in use.
class BULLET_CCD_API Environment
{
public:
    /// One box of the tree. It has two children, of which the left one follows the node in the
    /// array, or up to kLeaf objects.
    struct Node
    {
        Eigen::AlignedBox3d box{};
        std::int32_t right = kNone;  ///< right child; kNone for a leaf
        std::int32_t first = 0;      ///< first object of a leaf, in order()
        std::int32_t count = 0;
    };
    static constexpr std::size_t kLeaf = 2;

    Environment() = default;
    explicit Environment(std::span<const RigidBody> bodies) { reset(bodies); }

    /// Replaces the objects, in O(n log n). Allocates nothing once it has held as many.
    /// Throws std::invalid_argument if a motion is not finite.
    void reset(std::span<const RigidBody> bodies);

    [[nodiscard]] std::span<const RigidBody> bodies() const { return m_bodies; }
    [[nodiscard]] bool moves(std::int32_t index) const
    {
        return m_moves[static_cast<std::size_t>(index)] != 0;
    }
    [[nodiscard]] std::size_t movingCount() const { return m_movingCount; }
    /// Bounds of an object over the whole step, in W [m].
    [[nodiscard]] const Eigen::AlignedBox3d& box(std::int32_t index) const
    {
        return m_boxes[static_cast<std::size_t>(index)];
    }
    /// Empty without objects; otherwise node 0 is the root.
    [[nodiscard]] std::span<const Node> nodes() const { return m_nodes; }
    [[nodiscard]] std::span<const std::int32_t> order() const { return m_order; }

private:
    void build(std::size_t begin, std::size_t end);

    std::vector<RigidBody> m_bodies;
    std::vector<std::uint8_t> m_moves;
    std::vector<Eigen::AlignedBox3d> m_boxes;
    std::vector<std::int32_t> m_order;
    std::vector<Node> m_nodes;
    std::size_t m_movingCount = 0;
};
}  // namespace bullet_ccd
