#include "bullet_ccd/hierarchy/ssv_split.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// Turns a binary tree into one of kArity with the smallest sum over its inner nodes of surface
/// times (children + overhead): the expected work of a search that comes by a node as often as its
/// surface says. Siblings stay adjacent.
///
/// By dynamic programming from the leaves up. Let g(n, k) be the least cost of the subtrees below
/// at most k nodes that together hold what is below n. With children l and r of n,
///     open(n, k) = min over a + b = k of g(l, a) + g(r, b),
///     g(n, 1) = min over k >= 2 of surface(n) (k + overhead) + open(n, k),
///     g(n, k) = min(g(n, k - 1), open(n, k)).
class Flattener
{
public:
    explicit Flattener(std::span<const SsvBinaryNode> binary) : m_binary(binary) {}

    std::vector<SsvBranch> run()
    {
        findCosts();
        m_branches.reserve(m_binary.size());
        m_branches.resize(1);
        flatten(0, m_binary[0]);
        return std::move(m_branches);
    }

private:
    /// g(n, k) at k - 1; zero for leaves.
    using Costs = std::array<float, kArity>;

    [[nodiscard]] static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
    [[nodiscard]] float cost(std::size_t node, int k) const { return m_costs[node][index(k - 1)]; }

    /// The least cost of opening a node into at most k, and how many of them the first child gets.
    [[nodiscard]] std::pair<float, int> open(const SsvBinaryNode& node, int k) const
    {
        const std::size_t left = index(node.first);
        std::pair<float, int> best(std::numeric_limits<float>::infinity(), 1);
        for (int a = 1; a < k; ++a)
        {
            best = std::min(best, {cost(left, a) + cost(left + 1, k - a), a});
        }
        return best;
    }

    [[nodiscard]] static float own(const SsvBinaryNode& node, int k)
    {
        constexpr float kOverhead = 1.0F;
        return node.surface * (static_cast<float>(k) + kOverhead);
    }

    void findCosts()
    {
        m_costs.assign(m_binary.size(), Costs{});
        for (std::size_t i = m_binary.size(); i-- > 0;)
        {
            const SsvBinaryNode& node = m_binary[i];
            if (node.isLeaf())
            {
                continue;
            }
            Costs opened{};
            float closed = std::numeric_limits<float>::infinity();
            for (int k = 2; k <= kArity; ++k)
            {
                opened[index(k - 1)] = open(node, k).first;
                closed = std::min(closed, own(node, k) + opened[index(k - 1)]);
            }
            m_costs[i][0] = closed;
            for (std::size_t k = 1; k < kArity; ++k)
            {
                m_costs[i][k] = std::min(m_costs[i][k - 1], opened[k]);
            }
        }
    }

    /// Up to kArity siblings.
    struct Children
    {
        std::array<std::size_t, kArity> nodes{};
        std::size_t count = 0;
    };

    /// Adds the nodes that g(node, k) stands for.
    void collect(std::size_t node, int k, Children& children) const
    {
        while (k > 1 && cost(node, k) == cost(node, k - 1))
        {
            --k;
        }
        if (k == 1)
        {
            children.nodes[children.count++] = node;
            return;
        }
        collectBelow(m_binary[node], k, children);
    }

    void collectBelow(const SsvBinaryNode& node, int k, Children& children) const
    {
        const int a = open(node, k).second;
        collect(index(node.first), a, children);
        collect(index(node.first) + 1, k - a, children);
    }

    void flatten(std::size_t out, const SsvBinaryNode& node)
    {
        m_branches[out] = {.first = node.begin, .count = 0, .begin = node.begin, .end = node.end};
        if (node.isLeaf())
        {
            return;
        }
        int best = 2;
        for (int k = 3; k <= kArity; ++k)
        {
            const auto total = [&](int i) { return own(node, i) + open(node, i).first; };
            best = total(k) < total(best) ? k : best;
        }
        Children children;
        collectBelow(node, best, children);
        const std::size_t first = m_branches.size();
        m_branches.resize(first + children.count);
        m_branches[out].first = static_cast<std::int32_t>(first);
        m_branches[out].count = static_cast<std::int32_t>(children.count);
        for (std::size_t i = 0; i < children.count; ++i)
        {
            flatten(first + i, m_binary[children.nodes[i]]);
        }
    }

    std::span<const SsvBinaryNode> m_binary;
    std::vector<Costs> m_costs;
    std::vector<SsvBranch> m_branches;
};
}  // namespace

std::vector<SsvBranch> flattened(std::span<const SsvBinaryNode> binary)
{
    return Flattener(binary).run();
}
}  // namespace bullet_ccd
