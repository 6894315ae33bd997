/// Priority queue of node pairs by time.
#pragma once

#include "bullet_ccd/toi/search/pair_scene.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// Earliest first; among equals the one that was pushed last, so that a contact is found before its
/// surroundings are searched.
///
/// Most pairs lie far in the future and are never taken out, so that pushing has to be cheap: only
/// what is due before a horizon is kept in a heap, the rest in no order. When the heap runs empty,
/// the horizon moves on.
class EarliestFirst
{
public:
    void clear()
    {
        m_near.clear();
        m_far.clear();
        m_pairs.clear();
        m_horizon = 0;
    }

    [[nodiscard]] bool empty() const { return m_near.empty() && m_far.empty(); }

    [[nodiscard]] std::size_t size() const { return m_near.size() + m_far.size(); }

    /// Appends all that waits to `pairs`, in no order, and forgets it.
    void moveTo(std::vector<NodePair>& pairs)
    {
        for (const std::vector<Key>* keys : {&m_near, &m_far})
        {
            for (const Key& key : *keys)
            {
                pairs.push_back(m_pairs[key.index]);
            }
        }
        clear();
    }

    /// Nothing in the queue is earlier. @pre not empty
    [[nodiscard]] double time()
    {
        settle();
        return std::bit_cast<double>(m_near.front().order & ~kTieBits);
    }

    /// The first pair; its time is that of the queue but for the last 20 bits. @pre not empty
    [[nodiscard]] const NodePair& top()
    {
        settle();
        return m_pairs[m_near.front().index];
    }

    /// @pre p.time >= 0
    void push(const NodePair& p)
    {
        const auto index = static_cast<std::uint32_t>(m_pairs.size());
        const std::uint64_t order =
            (std::bit_cast<std::uint64_t>(p.time) & ~kTieBits) | (~std::uint64_t{index} & kTieBits);
        m_pairs.push_back(p);
        if (order > m_horizon)
        {
            m_far.push_back({.order = order, .index = index});
        }
        else
        {
            m_near.push_back({});
            rise(m_near.size() - 1, {.order = order, .index = index});
        }
    }

    /// @pre not empty
    void pop()
    {
        settle();
        const Key last = m_near.back();
        m_near.pop_back();
        if (!m_near.empty())
        {
            sink(0, last);
        }
    }

private:
    /// Compares as one integer: the bits of the time, a number >= 0, the last of them replaced by
    /// the complement of the index.
    struct Key
    {
        std::uint64_t order = 0;
        std::uint32_t index = 0;
    };
    static constexpr std::uint64_t kTieBits = (std::uint64_t{1} << 20) - 1;
    static constexpr std::size_t kChildren = 4;

    void rise(std::size_t at, const Key& key)
    {
        while (at > 0)
        {
            const std::size_t parent = (at - 1) / kChildren;
            if (m_near[parent].order <= key.order)
            {
                break;
            }
            m_near[at] = m_near[parent];
            at = parent;
        }
        m_near[at] = key;
    }

    void sink(std::size_t at, const Key& key)
    {
        const std::size_t size = m_near.size();
        Key* const keys = m_near.data();
        for (;;)
        {
            const std::size_t first = kChildren * at + 1;
            if (first >= size)
            {
                break;
            }
            std::size_t best = first;
            const std::size_t end = std::min(first + kChildren, size);
            for (std::size_t child = first + 1; child < end; ++child)
            {
                best = keys[child].order < keys[best].order ? child : best;
            }
            if (keys[best].order >= key.order)
            {
                break;
            }
            keys[at] = keys[best];
            at = best;
        }
        keys[at] = key;
    }

    void settle()
    {
        if (m_near.empty())
        {
            moveHorizon();
        }
    }

    /// To an eighth of the way from the earliest to the mean of what waits.
    void moveHorizon()
    {
        std::uint64_t earliest = m_far.front().order;
        double sum = 0.0;
        for (const Key& key : m_far)
        {
            earliest = std::min(earliest, key.order);
            sum += std::bit_cast<double>(key.order);
        }
        const auto first = std::bit_cast<double>(earliest);
        const double mean = sum / static_cast<double>(m_far.size());
        m_horizon =
            std::max(earliest, std::bit_cast<std::uint64_t>(first + 0.125 * (mean - first)));
        std::size_t waiting = 0;
        for (const Key& key : m_far)
        {
            if (key.order > m_horizon)
            {
                m_far[waiting++] = key;
            }
            else
            {
                m_near.push_back({});
                rise(m_near.size() - 1, key);
            }
        }
        m_far.resize(waiting);
    }

    std::vector<Key> m_near;  ///< a heap of four children a node
    std::vector<Key> m_far;   ///< all later than the horizon
    std::uint64_t m_horizon = 0;
    std::vector<NodePair> m_pairs;  ///< in the order of pushing, until clear()
};
}  // namespace bullet_ccd
