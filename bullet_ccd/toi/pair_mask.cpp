#include "bullet_ccd/math/check.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>

namespace bullet_ccd
{
namespace
{
/// A node is marked if all triangles below it are.
std::vector<std::uint8_t> marksOfNodes(const SsvTree& tree, std::span<const std::uint8_t> marks)
{
    tree.openAll();
    const std::span<const SsvNode> nodes = tree.nodes();
    std::vector<std::uint8_t> result(nodes.size(), 1);
    for (std::size_t i = nodes.size(); i-- > 0;)  // children come after their parent
    {
        const SsvNode& node = nodes[i];
        if (node.first == kNone)
        {
            continue;
        }
        if (node.isLeaf())
        {
            result[i] = marks[static_cast<std::size_t>(tree.triangle(node.first))];
            continue;
        }
        for (std::int32_t k = 0; k < node.count; ++k)
        {
            result[i] &= result[static_cast<std::size_t>(node.first + k)];
        }
    }
    return result;
}

std::vector<std::uint8_t> normalised(const SsvTree& tree, std::span<const std::uint8_t> marks)
{
    require(marks.size() == tree.mesh().triangles.size(),
            "PairMask: " + std::to_string(marks.size()) + " marks for " +
                std::to_string(tree.mesh().triangles.size()) +
                " triangles: give one mark a triangle");
    std::vector<std::uint8_t> result(marks.size());
    std::transform(marks.begin(),
                   marks.end(),
                   result.begin(),
                   [](std::uint8_t mark) -> std::uint8_t { return mark != 0 ? 1 : 0; });
    return result;
}

bool anyMarked(const std::vector<std::uint8_t>& marks)
{
    return std::find(marks.begin(), marks.end(), 1) != marks.end();
}
}  // namespace

PairMask::PairMask(const SsvTree& treeA,
                   const SsvTree& treeB,
                   std::span<const std::uint8_t> marksA,
                   std::span<const std::uint8_t> marksB)
    : m_marksA(normalised(treeA, marksA)),
      m_marksB(normalised(treeB, marksB)),
      m_nodesA(marksOfNodes(treeA, m_marksA)),
      m_nodesB(marksOfNodes(treeB, m_marksB)),
      m_isEmpty(!anyMarked(m_marksA) || !anyMarked(m_marksB))
{
}

PairMask maskNear(const SsvTree& treeA,
                  const SsvTree& treeB,
                  std::span<const Eigen::Isometry3d> posesOfAInB,
                  double reach)
{
    std::vector<std::uint8_t> marksA(treeA.mesh().triangles.size(), 0);
    std::vector<std::uint8_t> marksB(treeB.mesh().triangles.size(), 0);
    markTrianglesWithin(treeA, treeB, posesOfAInB, reach, marksA, marksB);
    return {treeA, treeB, marksA, marksB};
}
}  // namespace bullet_ccd
