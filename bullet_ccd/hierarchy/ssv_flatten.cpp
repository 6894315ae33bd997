#include "bullet_ccd/hierarchy/ssv_split.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <algorithm>
#include <array>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// Turns a binary tree into one of kArity: the children of a node are the cut below it that is
/// reached by always opening the largest. Siblings stay adjacent.
class Flattener
{
public:
    explicit Flattener(std::span<const SsvBinaryNode> binary) : m_binary(binary)
    {
        m_branches.reserve(binary.size());
    }

    std::vector<SsvBranch> run()
    {
        m_branches.resize(1);
        flatten(0, m_binary[0]);
        return std::move(m_branches);
    }

private:
    void flatten(std::size_t out, const SsvBinaryNode& node)
    {
        m_branches[out] = {.first = node.begin, .count = 0, .begin = node.begin, .end = node.end};
        if (node.isLeaf())
        {
            return;
        }
        std::array<SsvBinaryNode, kArity> children;
        std::size_t count = 0;
        const auto open = [&](const SsvBinaryNode& opened)
        {
            children[count++] = m_binary[static_cast<std::size_t>(opened.first)];
            children[count++] = m_binary[static_cast<std::size_t>(opened.first) + 1];
        };
        open(node);
        while (count < kArity)
        {
            const auto measure = [](const SsvBinaryNode& n)
            { return n.isLeaf() ? -1.0F : n.surface; };
            const auto largest =
                std::max_element(children.begin(),
                                 children.begin() + static_cast<std::ptrdiff_t>(count),
                                 [&](const SsvBinaryNode& a, const SsvBinaryNode& b)
                                 { return measure(a) < measure(b); });
            if (largest->isLeaf())
            {
                break;
            }
            const SsvBinaryNode opened = *largest;
            *largest = children[--count];
            open(opened);
        }
        const std::size_t first = m_branches.size();
        m_branches.resize(first + count);
        m_branches[out].first = static_cast<std::int32_t>(first);
        m_branches[out].count = static_cast<std::int32_t>(count);
        for (std::size_t i = 0; i < count; ++i)
        {
            flatten(first + i, children[i]);
        }
    }

    std::span<const SsvBinaryNode> m_binary;
    std::vector<SsvBranch> m_branches;
};

}  // namespace

std::vector<SsvBranch> flattened(std::span<const SsvBinaryNode> binary)
{
    return Flattener(binary).run();
}
}  // namespace bullet_ccd
