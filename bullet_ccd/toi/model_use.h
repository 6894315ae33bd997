/// How much of its models a query looked at.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/toi/toi.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace bullet_ccd
{
/// The triangles that searches looked at, each counted once however often it was met. What was not
/// looked at was left to its volumes: it can be left out of the meshes, and the answers stay.
///
/// Distances at a single pose, which queries ask for the details of a contact, are not noted.
class BULLET_CCD_API ModelUse
{
public:
    /// One entry for each triangle of the tree's mesh, 1 where it was looked at; empty for a tree
    /// of which none was.
    [[nodiscard]] std::span<const std::uint8_t> marks(const SsvTree& tree) const;
    /// How many triangles of a tree were looked at.
    [[nodiscard]] std::size_t count(const SsvTree& tree) const;
    /// The same of all trees.
    [[nodiscard]] std::size_t count() const { return m_total; }
    /// Trees of which a triangle was looked at.
    [[nodiscard]] std::size_t trees() const { return m_trees.size(); }

    /// Called by the searches.
    void note(const SsvTree& tree, std::int32_t triangle);

private:
    struct Marks
    {
        std::vector<std::uint8_t> triangles;
        std::size_t count = 0;
    };
    std::unordered_map<const SsvTree*, Marks> m_trees;
    std::size_t m_total = 0;
};

/// From now on, queries with this workspace note in `use` what they look at; null: nowhere.
/// @pre `use` and the trees of the queries outlive this.
BULLET_CCD_API void noteModelUse(ToiWorkspace& work, ModelUse* use);
}  // namespace bullet_ccd
