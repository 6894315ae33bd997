#include "tools/support/obstacles/model_share.h"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
/// With commas between the thousands.
std::string grouped(std::size_t n)
{
    std::string text = std::to_string(n);
    for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
    {
        text.insert(static_cast<std::size_t>(at), ",");
    }
    return text;
}

/// Triangles that any of them looked at.
std::size_t countOf(std::span<const ModelUse> uses, const SsvTree& tree)
{
    if (uses.size() == 1)
    {
        return uses.front().count(tree);
    }
    std::vector<std::uint8_t> all(tree.mesh().triangles.size(), 0);
    for (const ModelUse& use : uses)
    {
        const std::span<const std::uint8_t> marks = use.marks(tree);
        for (std::size_t k = 0; k < marks.size(); ++k)
        {
            all[k] |= marks[k];
        }
    }
    return static_cast<std::size_t>(std::count(all.begin(), all.end(), std::uint8_t{1}));
}
}  // namespace

ModelShare::ModelShare(std::span<const ModelUse> uses, std::span<const SsvTree* const> trees)
{
    std::map<const SsvTree*, std::size_t> counts;  // bodies may share a tree
    for (const SsvTree* tree : trees)
    {
        if (tree == nullptr)
        {
            continue;
        }
        const auto [known, isNew] = counts.try_emplace(tree, 0);
        if (isNew)
        {
            known->second = countOf(uses, *tree);
            triangles += known->second;
            ofTriangles += tree->mesh().triangles.size();
        }
        ++ofBodies;
        bodies += known->second > 0 ? 1 : 0;
    }
}

std::string plainText(const ModelShare& share)
{
    const std::string joints =
        share.ofJoints == 0 ? "" : fmt::format(", {} of {} joints", share.joints, share.ofJoints);
    return fmt::format("{} of {} bodies, {} of {} triangles{}",
                       grouped(share.bodies),
                       grouped(share.ofBodies),
                       grouped(share.triangles),
                       grouped(share.ofTriangles),
                       joints);
}

std::string readableText(const ModelShare& share)
{
    return "  needed      " + plainText(share) + "\n";
}

std::string jsonText(const ModelShare& share)
{
    return fmt::format(
        R"("needed": {{"bodies": {}, "of_bodies": {}, "triangles": {}, "of_triangles": {}{}}})",
        share.bodies,
        share.ofBodies,
        share.triangles,
        share.ofTriangles,
        share.ofJoints == 0
            ? ""
            : fmt::format(R"(, "joints": {}, "of_joints": {})", share.joints, share.ofJoints));
}
}  // namespace bullet_ccd::tools
