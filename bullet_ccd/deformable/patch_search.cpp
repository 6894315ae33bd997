#include "bullet_ccd/deformable/patch_search.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace bullet_ccd
{
namespace
{
/// Pairs of nodes that threads share, about.
constexpr std::size_t kShared = 512;

class PatchSearch
{
public:
    struct Nodes
    {
        std::int32_t a = 0;
        std::int32_t b = 0;
    };

    PatchSearch(const SurfacePair& pair,
                std::int32_t index,
                std::size_t most,
                std::vector<PatchTask>& tasks)
        : m_pair(pair), m_index(index), m_most(most), m_tasks(tasks)
    {
    }

    /// All pairs of patches below the two nodes. Returns false if there are too many.
    bool run(const Nodes& from)
    {
        m_stack.push_back(from);
        while (!m_stack.empty() && m_tasks.size() <= m_most)
        {
            const Nodes nodes = m_stack.back();
            m_stack.pop_back();
            meet(nodes);
        }
        return m_tasks.size() <= m_most;
    }

    /// From the roots, level by level, until there are enough pairs of nodes to share; they are
    /// returned.
    std::vector<Nodes> spread()
    {
        m_stack.push_back({0, 0});
        while (!m_stack.empty() && m_stack.size() < kShared && m_tasks.size() <= m_most)
        {
            std::vector<Nodes> level;
            level.swap(m_stack);
            std::ranges::for_each(level, [this](const Nodes& nodes) { meet(nodes); });
        }
        return std::move(m_stack);
    }

private:
    /// All pairs of a child of one node with one of the other; of a node with itself each pair
    /// once.
    void meet(const Nodes& nodes)
    {
        const SurfaceNode& nodeA = m_pair.a->node(nodes.a);
        const SurfaceNode& nodeB = m_pair.b->node(nodes.b);
        const bool isSame = m_pair.isOneSurface() && nodes.a == nodes.b;
        for (int i = 0; i < nodeA.count; ++i)
        {
            const std::int32_t childA = nodeA.child[i];
            if (isSame)
            {
                add(childA, childA, 0.0F);
            }
            alignas(32) float entry[8];
            const MovingBox box = shifted(m_pair.a->box(childA), m_pair.shift[0]);
            unsigned meeting = m_kernels.childrenMeeting(nodeB, box, entry);
            if (isSame)
            {
                meeting &= ~0U << static_cast<unsigned>(i + 1);
            }
            for (; meeting != 0; meeting &= meeting - 1)
            {
                const int j = std::countr_zero(meeting);
                add(childA, nodeB.child[j], entry[j]);
            }
        }
    }

    void add(std::int32_t childA, std::int32_t childB, float entry)
    {
        if ((m_pair.a->idle(childA) & m_pair.b->idle(childB) & m_pair.idle) != 0)
        {
            return;
        }
        if (childA >= 0 && childB >= 0)
        {
            m_stack.push_back({childA, childB});
        }
        else if (childA >= 0)
        {
            openA(childA, childB);
        }
        else if (childB >= 0)
        {
            openB(childA, childB);
        }
        else
        {
            m_tasks.push_back({m_index, ~childA, ~childB, entry});
        }
    }

    /// A node of A against a patch of B.
    void openA(std::int32_t node, std::int32_t patch)
    {
        alignas(32) float entry[8];
        const MovingBox box = shifted(m_pair.b->box(patch), m_pair.shift[1]);
        const SurfaceNode& nodeA = m_pair.a->node(node);
        for (unsigned m = m_kernels.childrenMeeting(nodeA, box, entry); m != 0; m &= m - 1)
        {
            const int i = std::countr_zero(m);
            add(nodeA.child[i], patch, entry[i]);
        }
    }
    void openB(std::int32_t patch, std::int32_t node)
    {
        alignas(32) float entry[8];
        const MovingBox box = shifted(m_pair.a->box(patch), m_pair.shift[0]);
        const SurfaceNode& nodeB = m_pair.b->node(node);
        for (unsigned m = m_kernels.childrenMeeting(nodeB, box, entry); m != 0; m &= m - 1)
        {
            const int i = std::countr_zero(m);
            add(patch, nodeB.child[i], entry[i]);
        }
    }

    const SurfaceKernels& m_kernels = surfaceKernels();
    const SurfacePair& m_pair;
    std::int32_t m_index;
    std::size_t m_most;
    std::vector<PatchTask>& m_tasks;
    std::vector<Nodes> m_stack;
};
}  // namespace

SurfacePair surfacePair(const DeformableSurface::Data& a,
                        const DeformableSurface::Data& b,
                        double separation,
                        double distance)
{
    SurfacePair pair{.a = &a, .b = &b, .separation = separation, .shift = {}};
    const Eigen::Vector3d way = a.centre - b.centre;
    // Places are rounded to single precision relative to the centres, their shift once more, boxes
    // or vertices are shifted: together below 6e-8 (2 hA + 2 hB + 2 |way|) on either side.
    const double size = a.halfExtent + b.halfExtent + way.cwiseAbs().maxCoeff();
    const double pad = 1.0001 * distance + 4e-7 * size + 1e-37;
    for (int k = 0; k < 6; ++k)
    {
        const double offset = way[k % 3];
        pair.shift[0].low[k] = static_cast<float>(offset - pad);
        pair.shift[0].high[k] = static_cast<float>(offset + pad);
        pair.shift[1].low[k] = static_cast<float>(-offset - pad);
        pair.shift[1].high[k] = static_cast<float>(-offset + pad);
    }
    return pair;
}

bool findPatchPairs(const SurfacePair& pair,
                    std::int32_t index,
                    std::size_t most,
                    int threads,
                    std::vector<PatchTask>& tasks)
{
    PatchSearch search(pair, index, most, tasks);
    if (threads == 1)
    {
        return search.run({0, 0});
    }
    const std::vector<PatchSearch::Nodes> shared = search.spread();
    std::vector<std::vector<PatchTask>> found(static_cast<std::size_t>(threads));
    std::atomic<std::size_t> next = 0;
    const auto searchSome = [&](int thread)
    {
        PatchSearch own(pair, index, most, found[static_cast<std::size_t>(thread)]);
        for (std::size_t i = next++; i < shared.size() && own.run(shared[i]); i = next++)
        {
        }
    };
    if (!shared.empty())
    {
        tbb::task_arena arena(threads);
        arena.execute([&] { tbb::parallel_for(0, threads, searchSome); });
    }
    for (const std::vector<PatchTask>& some : found)
    {
        tasks.insert(tasks.end(), some.begin(), some.end());
    }
    return tasks.size() <= most;
}
}  // namespace bullet_ccd
