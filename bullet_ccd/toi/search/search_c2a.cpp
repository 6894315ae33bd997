#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <array>
#include <limits>

namespace bullet_ccd
{
namespace
{
/// Controlled conservative advancement: all pairs are looked at from one common time, which then
/// moves on by the smallest certified step. In the queue `time` is where a pair's own step ends.
///
/// Any cut through the pairs of nodes covers all pairs of triangles, so its smallest step is a safe
/// one, however shallow the cut. The triangles that limited the last step are looked at first: a
/// cut whose smallest step is at least half of theirs is deep enough. As long as no triangles have
/// been met, a step may cost a number of node pairs that doubles whenever steps become short. So
/// far apart the cuts are shallow, and near contact they reach the triangles; no unit of length
/// enters.
class ControlledAdvancement
{
public:
    explicit ControlledAdvancement(SearchState& state) : m_state(state), m_queue(state.queue) {}

    void run()
    {
        double time = 0.0;
        double lastStep = 1.0;
        while (time <= 1.0 && !m_state.hit.found())
        {
            const double next = advance(time);
            if (next - time < 0.5 * lastStep)
            {
                // No further than it can be spent: it would overflow.
                m_budget *= m_budget <= m_state.options.maxIterations / 2 ? 2 : 1;
            }
            lastStep = next - time;
            time = next;
        }
    }

private:
    /// One step from `now`: the end of the smallest certified step over a cut.
    double advance(double now)
    {
        m_queue.clear();
        m_state.certified = now;
        std::int64_t spent = 0;
        std::array<NodePair, kArity> next{};
        for (std::int32_t i = 0; i < m_state.scene.size(); ++i)
        {
            next[0] = {.time = now, .pair = i, .nodeA = 0, .nodeB = 0};
            examine(now, {next.data(), 1});
        }
        double trianglesEnd = std::numeric_limits<double>::infinity();
        if (m_limiting.pair != kNone)
        {
            NodePair leaves = m_limiting;
            leaves.time = now;
            trianglesEnd = endOfTriangles(leaves);
        }
        while (!m_queue.empty() && !m_state.hit.found())
        {
            const double earliest = std::max(now, m_queue.time());
            const NodePair p = m_queue.top();
            checkLimit(m_state, now, p.pair);
            const bool deepEnough = earliest - now >= 0.5 * (trianglesEnd - now) ||
                                    (spent >= m_budget && earliest > now);
            if (deepEnough)
            {
                return std::min(earliest, trianglesEnd);
            }
            m_queue.pop();
            ++spent;
            if (m_state.scene.nodeA(p).isLeaf() && m_state.scene.nodeB(p).isLeaf())
            {
                NodePair leaves = p;
                leaves.time = now;
                const double end = endOfTriangles(leaves);
                if (end < trianglesEnd)
                {
                    trianglesEnd = end;
                    m_limiting = p;
                }
                continue;
            }
            NodePair here = p;
            here.time = now;
            if (meetsBelow(m_state, here))
            {
                break;
            }
            const Opening opening(m_state.scene.nodeA(p), m_state.scene.nodeB(p));
            m_state.scene.open(p, opening.openA);
            for (std::int32_t k = 0; k < opening.count; ++k)
            {
                next[static_cast<std::size_t>(k)] = opening.child(here, k);
            }
            const auto count = static_cast<std::size_t>(opening.count);
            examine(now, {next.data(), count});
        }
        return m_state.hit.found() ? now : trianglesEnd;
    }

    /// Where the certified step of two leaves ends; infinity if they cannot touch or do so now.
    double endOfTriangles(NodePair& leaves)
    {
        return advanceTriangles(m_state, leaves) ? leaves.time
                                                 : std::numeric_limits<double>::infinity();
    }

    void examine(double now, std::span<NodePair> pairs)
    {
        std::array<float, NodeBatch::kLanes> steps;
        m_state.scene.steps(pairs, m_state.counters, steps.data());
        for (std::size_t i = 0; i < pairs.size(); ++i)
        {
            pairs[i].time = now + static_cast<double>(steps[i]);
            if (pairs[i].time <= 1.0)
            {
                m_queue.push(pairs[i]);
            }
        }
    }

    SearchState& m_state;
    EarliestFirst& m_queue;
    std::int64_t m_budget = 32;
    NodePair m_limiting{};  ///< the triangles that ended the last step that met any
};
}  // namespace

void searchC2A(SearchState& state)
{
    ControlledAdvancement(state).run();
}
}  // namespace bullet_ccd
