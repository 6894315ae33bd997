/// Priority queue of node pairs by time.
#pragma once

#include "bullet_ccd/toi/pair_scene.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// Earliest first; among equals the one that was pushed last, so that a contact is found before its
/// surroundings are searched. A heap of four children a node over 16-byte keys: most pairs are
/// pushed and never taken out, so that pushing has to be cheap, and a node's children share a cache
/// line.
class EarliestFirst
{
public:
    void clear()
    {
        m_keys.clear();
        m_pairs.clear();
    }
    [[nodiscard]] bool empty() const { return m_keys.empty(); }
    [[nodiscard]] const NodePair& top() const { return m_pairs[m_keys.front().index]; }

    void push(const NodePair& p)
    {
        const Key key{.time = p.time, .index = static_cast<std::uint32_t>(m_pairs.size())};
        m_pairs.push_back(p);
        std::size_t at = m_keys.size();
        m_keys.push_back(key);
        while (at > 0)
        {
            const std::size_t parent = (at - 1) / kChildren;
            if (!before(key, m_keys[parent]))
            {
                break;
            }
            m_keys[at] = m_keys[parent];
            at = parent;
        }
        m_keys[at] = key;
    }

    void pop()
    {
        const Key key = m_keys.back();
        m_keys.pop_back();
        const std::size_t size = m_keys.size();
        if (size == 0)
        {
            return;
        }
        std::size_t at = 0;
        for (;;)
        {
            const std::size_t first = kChildren * at + 1;
            if (first >= size)
            {
                break;
            }
            std::size_t best = first;
            const std::size_t end = first + kChildren < size ? first + kChildren : size;
            for (std::size_t child = first + 1; child < end; ++child)
            {
                best = before(m_keys[child], m_keys[best]) ? child : best;
            }
            if (!before(m_keys[best], key))
            {
                break;
            }
            m_keys[at] = m_keys[best];
            at = best;
        }
        m_keys[at] = key;
    }

private:
    static constexpr std::size_t kChildren = 4;

    struct Key
    {
        double time;
        std::uint32_t index;
    };
    static bool before(const Key& a, const Key& b)
    {
        return a.time < b.time || (a.time == b.time && a.index > b.index);
    }

    std::vector<Key> m_keys;
    std::vector<NodePair> m_pairs;  ///< in the order of pushing, until clear()
};
}  // namespace bullet_ccd
