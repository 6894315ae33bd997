#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <array>
#include <limits>

namespace bullet_ccd
{
namespace
{
/// Invariant: every pair of triangles that could touch before min(1, hit.time) is below a pair in
/// the queue, or in the batch in hand, whose time is a lower bound of its contact. The search ends
/// because every pair taken out either goes down one level of a finite tree or moves ahead by a
/// step that is bounded below by its margin over the largest speed. Where many pairs touch at
/// once, rounding puts some of them a little before the contact that was found: the search ends as
/// soon as the earliest of them is past the time from which on that contact is near enough, and
/// there is the answer.
///
/// A long queue costs more than it saves: each of its pairs waits for memory. What waits then is
/// handed to the search by intervals, which keeps few pairs and sees them one after the other.
class BestFirst
{
public:
    explicit BestFirst(SearchState& state) : m_state(state), m_queue(state.queue) {}

    void run()
    {
        m_queue.clear();
        for (std::int32_t i = 0; i < m_state.scene.size(); ++i)
        {
            // As if it had come a long way: the roots themselves are to be looked at.
            m_queue.push({.time = m_state.begin,
                          .pair = i,
                          .nodeA = 0,
                          .nodeB = 0,
                          .lastStep = std::numeric_limits<float>::infinity()});
        }
        while (!m_queue.empty() && m_queue.time() < m_state.hit.enough)
        {
            if (m_queue.size() > kMostWaiting)
            {
                const double time = m_queue.time();
                m_state.front.clear();
                m_queue.moveTo(m_state.front);
                searchIntervalsFrom(m_state, time);
                return;
            }
            checkLimit(m_state, m_queue.time(), m_queue.top().pair);
            const std::size_t count = collect();
            if (count > 0)
            {
                evaluate(count);
            }
        }
        if (!m_queue.empty() && m_queue.time() < m_state.hit.time)
        {
            moveHit(m_state, m_queue.time());
        }
    }

private:
    static constexpr std::size_t kMostWaiting = 1U << 12;

    /// Takes the earliest pairs out of the queue: triangles are dealt with on the way, nodes fill a
    /// batch. Returns the size of the batch.
    std::size_t collect()
    {
        std::size_t count = 0;
        while (!m_queue.empty() && m_queue.time() < m_state.hit.enough)
        {
            NodePair p = m_queue.top();
            const SsvNode& a = m_state.scene.nodeA(p);
            const SsvNode& b = m_state.scene.nodeB(p);
            if (a.isLeaf() && b.isLeaf())
            {
                m_queue.pop();
                m_state.certified = count > 0 ? m_batch[0].time : p.time;
                if (advanceTriangles(m_state, p))
                {
                    m_queue.push(p);
                }
                continue;
            }
            if (count > 0 && !m_state.scene.canShareBatch(p, m_batch[0]))
            {
                break;
            }
            if (meetsBelow(m_state, p))
            {
                m_queue.pop();
                continue;
            }
            // A pair that came far for its size is worth another step before it is opened.
            const double way =
                static_cast<double>(p.lastStep) * m_state.scene.pair(p.pair).speedScale;
            constexpr double kFar = 0.5;
            const bool goesOn = way >= kFar * static_cast<double>(a.size() + b.size());
            const Opening opening(a, b);
            const auto added = static_cast<std::size_t>(goesOn ? 1 : opening.count);
            if (count + added > m_batch.size())
            {
                break;
            }
            m_queue.pop();
            if (!goesOn)
            {
                m_state.scene.open(p, opening.openA);
            }
            for (std::size_t k = 0; k < added; ++k)
            {
                m_batch[count] = goesOn ? p : opening.child(p, static_cast<std::int32_t>(k));
                count += m_state.scene.isExempt(m_batch[count]) ? 0 : 1;
            }
        }
        return count;
    }

    void evaluate(std::size_t count)
    {
        std::array<float, NodeBatch::kLanes> steps;
        m_state.scene.steps({m_batch.data(), count}, m_state.counters, steps.data());
        for (std::size_t i = 0; i < count; ++i)
        {
            NodePair& p = m_batch[i];
            p.time += static_cast<double>(steps[i]);
            p.lastStep = steps[i];
            if (p.time <= m_state.end && p.time < m_state.hit.time)
            {
                m_queue.push(p);
            }
        }
    }

    SearchState& m_state;
    EarliestFirst& m_queue;
    std::array<NodePair, NodeBatch::kLanes> m_batch{};
};
}  // namespace

void searchBestFirst(SearchState& state)
{
    BestFirst(state).run();
}
}  // namespace bullet_ccd
