#include "bullet_ccd/toi/model_use.h"

#include "bullet_ccd/toi/articulated/toi_scratch.h"

namespace bullet_ccd
{
std::span<const std::uint8_t> ModelUse::marks(const SsvTree& tree) const
{
    const auto found = m_trees.find(&tree);
    return found == m_trees.end() ? std::span<const std::uint8_t>{}
                                  : std::span<const std::uint8_t>(found->second.triangles);
}

std::size_t ModelUse::count(const SsvTree& tree) const
{
    const auto found = m_trees.find(&tree);
    return found == m_trees.end() ? 0 : found->second.count;
}

void ModelUse::note(const SsvTree& tree, std::int32_t triangle)
{
    Marks& marks = m_trees[&tree];
    marks.triangles.resize(tree.mesh().triangles.size());
    std::uint8_t& mark = marks.triangles[static_cast<std::size_t>(triangle)];
    if (mark == 0)
    {
        mark = 1;
        ++marks.count;
        ++m_total;
    }
}

void noteModelUse(ToiWorkspace& work, ModelUse* use)
{
    work.scratch().state.use = use;
}
}  // namespace bullet_ccd
