#include "bullet_ccd/deformable/deformable_toi.h"

#include "bullet_ccd/deformable/feature_search.h"
#include "bullet_ccd/deformable/pursue.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>
#include <string>
#include <tuple>

namespace bullet_ccd
{
struct DeformableWorkspace::Scratch
{
    std::vector<SurfacePair> surfaces;
    std::vector<PatchTask> tasks;
    std::vector<PatchTask> sorted;
    std::vector<std::vector<DeformableContact>> found;  ///< by thread
};

DeformableWorkspace::DeformableWorkspace() : m_scratch(std::make_unique<Scratch>()) {}
DeformableWorkspace::~DeformableWorkspace() = default;
DeformableWorkspace::DeformableWorkspace(DeformableWorkspace&&) noexcept = default;
DeformableWorkspace& DeformableWorkspace::operator=(DeformableWorkspace&&) noexcept = default;

namespace
{
/// Tasks that a thread takes at once.
constexpr std::size_t kTasksAtOnce = 256;
/// How far ahead patches are fetched.
constexpr std::size_t kTasksAhead = 3;

void checkQuery(std::span<const DeformableBody> bodies, const DeformableOptions& options)
{
    checkElementaryOptions({.tolerance = options.tolerance,
                            .minimumSeparation = options.minimumSeparation,
                            .depth = options.depth,
                            .maxIterations = options.maxIterationsOfPair});
    require(options.maxIterations > 0, "maxIterations must be positive");
    require(options.threads > 0, "a query needs at least one thread");
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        const std::string name = "deformable body " + std::to_string(i);
        require(bodies[i].surface != nullptr, name + " has no surface");
        require(bodies[i].deviation >= 0.0 && std::isfinite(bodies[i].deviation),
                name + ": the deviation must be zero or a positive distance");
        require(options.depth != ElementaryDepth::Exact || bodies[i].deviation == 0.0,
                name + " has a deviation: ElementaryDepth::Exact needs straight paths");
    }
}

void pairSurfaces(std::span<const DeformableBody> bodies,
                  const DeformableOptions& options,
                  std::vector<SurfacePair>& pairs)
{
    pairs.clear();
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        for (std::size_t j = i; j < bodies.size(); ++j)
        {
            if ((i == j && !bodies[i].selfCollision) ||
                (options.isPairExempt &&
                 options.isPairExempt(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j))))
            {
                continue;
            }
            const double separation =
                options.minimumSeparation + bodies[i].deviation + bodies[j].deviation;
            pairs.push_back(surfacePair(bodies[i].surface->data(),
                                        bodies[j].surface->data(),
                                        separation,
                                        separation + options.tolerance));
            pairs.back().bodyA = static_cast<std::int32_t>(i);
            pairs.back().bodyB = static_cast<std::int32_t>(j);
        }
    }
}

/// What can meet early comes first; roughly, because it only saves time.
void sortByEntry(std::vector<PatchTask>& tasks, std::vector<PatchTask>& sorted)
{
    constexpr int kBuckets = 64;
    const auto bucketOf = [](const PatchTask& task)
    { return static_cast<std::size_t>(std::clamp(int(task.entry * kBuckets), 0, kBuckets - 1)); };
    std::array<std::size_t, kBuckets + 1> begin{};
    for (const PatchTask& task : tasks)
    {
        ++begin[bucketOf(task) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    sorted.resize(tasks.size());
    for (const PatchTask& task : tasks)
    {
        sorted[begin[bucketOf(task)]++] = task;
    }
    tasks.swap(sorted);
}

/// What all threads have found until `latest`, in order.
std::vector<DeformableContact> inOrder(const std::vector<std::vector<DeformableContact>>& found,
                                       double latest,
                                       int threads)
{
    struct Place
    {
        double time;
        const DeformableContact* contact;
    };
    std::vector<Place> order;
    for (const std::vector<DeformableContact>& some : found)
    {
        order.reserve(order.size() + some.size());
        for (const DeformableContact& contact : some)
        {
            if (contact.time <= latest)
            {
                order.push_back({contact.time, &contact});
            }
        }
    }
    const auto key = [](const DeformableContact& c)
    { return std::tie(c.kind, c.bodyA, c.bodyB, c.vertices); };
    const auto isLess = [&](const Place& a, const Place& b)
    { return a.time != b.time ? a.time < b.time : key(*a.contact) < key(*b.contact); };
    if (threads == 1)
    {
        std::ranges::sort(order, isLess);
    }
    else
    {
        tbb::task_arena arena(threads);
        arena.execute([&] { tbb::parallel_sort(order.begin(), order.end(), isLess); });
    }
    std::vector<DeformableContact> sorted;
    sorted.reserve(order.size());
    for (const Place& place : order)
    {
        sorted.push_back(*place.contact);
    }
    return sorted;
}

class DeformableQuery
{
public:
    DeformableQuery(std::span<const DeformableBody> bodies,
                    const DeformableOptions& options,
                    bool firstOnly,
                    DeformableWorkspace::Scratch& scratch)
        : m_options(options), m_scratch(scratch)
    {
        checkQuery(bodies, options);
        pairSurfaces(bodies, options, scratch.surfaces);
        m_state.surfaces = scratch.surfaces;
        m_state.options = &options;
        m_state.firstOnly = firstOnly;
    }

    DeformableResult run()
    {
        DeformableResult result;
        if (!findTasks() || !examineTasks(result))
        {
            result.status = m_isStopped ? ToiStatus::Stopped : ToiStatus::IterationLimit;
            result.time = 0.0;
            return result;
        }
        const double latest = m_state.firstOnly ? m_state.earliest.load() : 1.0;
        result.contacts = inOrder(m_scratch.found, latest, m_options.threads);
        if (!result.contacts.empty())
        {
            result.status = result.contacts.front().status;
            result.time = result.contacts.front().time;
        }
        return result;
    }

private:
    [[nodiscard]] bool findTasks()
    {
        std::vector<PatchTask>& tasks = m_scratch.tasks;
        tasks.clear();
        for (std::size_t i = 0; i < m_scratch.surfaces.size(); ++i)
        {
            if (!findPatchPairs(m_scratch.surfaces[i],
                                static_cast<std::int32_t>(i),
                                static_cast<std::size_t>(m_options.maxIterations),
                                m_options.threads,
                                tasks))
            {
                return false;
            }
        }
        if (m_state.firstOnly)
        {
            sortByEntry(tasks, m_scratch.sorted);
        }
        return true;
    }

    /// Returns false if there were too many pairs.
    [[nodiscard]] bool examineTasks(DeformableResult& result)
    {
        m_scratch.found.resize(static_cast<std::size_t>(m_options.threads));
        std::vector<FeatureSearch> searches;
        for (std::vector<DeformableContact>& found : m_scratch.found)
        {
            found.clear();
            searches.emplace_back(m_state, found);
        }
        if (m_options.threads == 1)
        {
            examineSome(searches.front());
        }
        else
        {
            tbb::task_arena arena(m_options.threads);
            arena.execute(
                [&]
                {
                    tbb::parallel_for(0,
                                      m_options.threads,
                                      [&](int i)
                                      { examineSome(searches[static_cast<std::size_t>(i)]); });
                });
        }
        for (const FeatureSearch& search : searches)
        {
            result.counters.patchPairs += search.counters().patchPairs;
            result.counters.featurePairs += search.counters().featurePairs;
            result.counters.advanced += search.counters().advanced;
        }
        return m_examined.load() <= m_options.maxIterations && !m_isStopped;
    }

    [[nodiscard]] bool mustStop()
    {
        if (m_options.stop.isGiven() && m_options.stop.isDue())
        {
            m_isStopped = true;
        }
        return m_isStopped;
    }

    void examineSome(FeatureSearch& search)
    {
        const std::vector<PatchTask>& tasks = m_scratch.tasks;
        std::int64_t counted = 0;
        const auto count = [&]
        {
            const std::int64_t now = search.counters().featurePairs;
            m_examined.fetch_add(now - counted);
            counted = now;
        };
        for (std::size_t begin = m_next.fetch_add(kTasksAtOnce);
             begin < tasks.size() && m_examined.load() <= m_options.maxIterations && !mustStop();
             begin = m_next.fetch_add(kTasksAtOnce))
        {
            const std::size_t end = std::min(begin + kTasksAtOnce, tasks.size());
            for (std::size_t i = begin; i < end; ++i)
            {
                if (i + kTasksAhead < end)
                {
                    search.prefetch(tasks[i + kTasksAhead]);
                }
                search.examine(tasks[i]);
            }
            count();
        }
        search.finish();
        count();
    }

    const DeformableOptions& m_options;
    DeformableWorkspace::Scratch& m_scratch;
    FeatureSearchState m_state;
    std::atomic<std::size_t> m_next = 0;
    std::atomic<std::int64_t> m_examined = 0;
    std::atomic<bool> m_isStopped = false;
};
}  // namespace

DeformableResult deformableContacts(std::span<const DeformableBody> bodies,
                                    const DeformableOptions& options,
                                    DeformableWorkspace& work)
{
    return DeformableQuery(bodies, options, false, work.scratch()).run();
}

DeformableResult deformableToi(std::span<const DeformableBody> bodies,
                               const DeformableOptions& options,
                               DeformableWorkspace& work)
{
    return DeformableQuery(bodies, options, true, work.scratch()).run();
}

RigidStep rigidStep(const TriangleMesh& mesh, const RigidMotion& motion)
{
    const Eigen::Isometry3d X_W0 = motion.at(0.0).X_W;
    const Eigen::Isometry3d X_W1 = motion.at(1.0).X_W;
    require(X_W0.matrix().allFinite() && X_W1.matrix().allFinite(),
            "rigidStep(): the motion is not finite: give finite poses and velocities");
    const AccelerationBound bound = motion.accelerationBound();
    RigidStep step;
    double radius = 0.0;
    for (const Eigen::Vector3d& x : mesh.vertices)
    {
        step.start.push_back(X_W0 * x);
        step.end.push_back(X_W1 * x);
        radius = std::max(radius, x.norm());
    }
    // A path whose acceleration stays below a is at most a / 8 off its chord over a unit of time.
    step.deviation = (bound.constant + bound.perRadius * radius) / 8.0;
    return step;
}
}  // namespace bullet_ccd
