#include "tools/ccd_cli/run/model_share.h"

#include <fmt/format.h>
#include <set>

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
}  // namespace

ModelShare::ModelShare(const ModelUse& use, std::span<const SsvTree* const> trees)
{
    std::set<const SsvTree*> known;  // one that several bodies share has its triangles once
    for (const SsvTree* tree : trees)
    {
        if (tree == nullptr)
        {
            continue;
        }
        ++ofBodies;
        bodies += use.count(*tree) > 0 ? 1 : 0;
        if (known.insert(tree).second)
        {
            triangles += use.count(*tree);
            ofTriangles += tree->mesh().triangles.size();
        }
    }
}

std::string readableText(const ModelShare& share)
{
    return fmt::format("  needed      {} of {} bodies, {} of {} triangles\n",
                       grouped(share.bodies),
                       grouped(share.ofBodies),
                       grouped(share.triangles),
                       grouped(share.ofTriangles));
}

std::string jsonText(const ModelShare& share)
{
    return fmt::format(
        R"("needed": {{"bodies": {}, "of_bodies": {}, "triangles": {}, "of_triangles": {}}})",
        share.bodies,
        share.ofBodies,
        share.triangles,
        share.ofTriangles);
}
}  // namespace bullet_ccd::tools
