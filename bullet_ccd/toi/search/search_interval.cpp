#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <array>

namespace bullet_ccd
{
namespace
{
/// Depth first over intervals of time, the earlier half first. In each interval every pair of nodes
/// is asked whether it keeps apart until the end. If not, it goes on from where it is certified: by
/// another step, if it came a good part of its size; else it waits for the halves, if it moves far
/// for its size until the end; else it is opened.
class Intervals
{
public:
    explicit Intervals(SearchState& state) : m_state(state) {}

    /// From the pairs in the front.
    void run(double begin)
    {
        process(begin, m_state.end, 0, m_state.front.size(), 0);
        const ToiOptions& options = m_state.options;
        if (m_state.hit.found() && options.anyWithin && m_state.hit.enough < m_state.hit.time)
        {
            moveHit(m_state, m_state.hit.enough);
        }
    }

private:
    /// Nothing later matters, and nothing at all where any contact will do. Where any distance
    /// within the tolerance will do, the contact that was found may as well be named where it
    /// begins to be as near as that.
    [[nodiscard]] double answer() const
    {
        if (m_state.anyContact && m_state.hit.found())
        {
            return -1.0;
        }
        return m_state.options.anyWithin ? m_state.hit.enough : m_state.hit.time;
    }
    [[nodiscard]] double last(double end) const { return std::min(end, answer()); }
    /// No later time of the pair matters.
    [[nodiscard]] double last(const NodePair& p, double end) const
    {
        return std::min(m_state.scene.pair(p.pair).until, last(end));
    }

    /// Node pairs front[begin, end) are those that may touch in [t0, t1]. All pairs are certified
    /// up to t0, and each up to its own time, from where it is looked at.
    void process(double t0, double t1, std::size_t begin, std::size_t end, int depth)
    {
        const std::size_t waiting = m_state.front.size();
        std::vector<NodePair>& work = m_state.work;
        work.assign(m_state.front.begin() + static_cast<std::ptrdiff_t>(begin),
                    m_state.front.begin() + static_cast<std::ptrdiff_t>(end));
        while (!work.empty() && t0 < answer())
        {
            checkLimit(m_state, t0, work.back().pair);
            processBatch(t0, last(t1), depth);
        }
        if (m_state.front.size() > waiting && t0 < answer())
        {
            const double middle = 0.5 * (t0 + last(t1));
            const std::size_t stop = m_state.front.size();
            process(t0, middle, waiting, stop, depth + 1);
            if (middle < answer())
            {
                process(middle, last(t1), waiting, stop, depth + 1);
            }
        }
        m_state.front.resize(waiting);
    }

    void processBatch(double t0, double t1, int depth)
    {
        std::vector<NodePair>& work = m_state.work;
        std::array<NodePair, NodeBatch::kLanes> batch{};
        std::size_t count = 0;
        while (count < batch.size() && !work.empty() &&
               (count == 0 || m_state.scene.canShareBatch(work.back(), batch[0])))
        {
            batch[count] = work.back();
            batch[count].time = std::max(t0, batch[count].time);
            work.pop_back();
            count += batch[count].time <= last(batch[count], t1) ? 1 : 0;
        }
        if (count == 0)
        {
            return;
        }
        std::array<float, NodeBatch::kLanes> steps;
        m_state.scene.steps({batch.data(), count}, m_state.counters, steps.data());
        for (std::size_t i = 0; i < count; ++i)
        {
            batch[i].time += static_cast<double>(steps[i]);
            batch[i].lastStep = steps[i];
            if (batch[i].time <= last(batch[i], t1))
            {
                dispatch(batch[i], t0, last(t1), depth);
            }
        }
    }

    void dispatch(NodePair p, double t0, double t1, int depth)
    {
        const SsvNode& a = m_state.scene.nodeA(p);
        const SsvNode& b = m_state.scene.nodeB(p);
        if (a.isLeaf() && b.isLeaf())
        {
            m_state.certified = t0;  // other pairs are only up to the beginning of the interval
            while (p.time <= last(p, t1) && advanceTriangles(m_state, p))
            {
            }
            return;
        }
        if (meetsBelow(m_state, p))
        {
            return;
        }
        constexpr double kGood = 0.1;
        constexpr double kFar = 4.0;
        constexpr int kDeepest = 8;
        const double speed = m_state.scene.pair(p.pair).speedScale;
        const double size = static_cast<double>(a.size()) + static_cast<double>(b.size());
        if (static_cast<double>(p.lastStep) * speed >= kGood * size)
        {
            m_state.work.push_back(p);
            return;
        }
        if ((last(p, t1) - p.time) * speed > kFar * size && depth < kDeepest)
        {
            m_state.front.push_back(p);
            return;
        }
        const Opening opening(a, b);
        m_state.scene.open(p, opening.openA);
        for (std::int32_t k = 0; k < opening.count; ++k)
        {
            const NodePair child = opening.child(p, k);
            if (!m_state.scene.isExempt(child))
            {
                m_state.work.push_back(child);
            }
        }
    }

    SearchState& m_state;
};
}  // namespace

void searchIntervals(SearchState& state)
{
    state.front.clear();
    for (std::int32_t i = 0; i < state.scene.size(); ++i)
    {
        const double time = std::max(state.begin, state.scene.pair(i).from);
        state.front.push_back({.time = time, .pair = i, .nodeA = 0, .nodeB = 0});
    }
    searchIntervalsFrom(state, state.begin);
}

void searchIntervalsFrom(SearchState& state, double begin)
{
    state.inOrder = false;
    Intervals(state).run(begin);
}
}  // namespace bullet_ccd
