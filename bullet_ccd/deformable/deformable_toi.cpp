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
};

DeformableWorkspace::DeformableWorkspace() : m_scratch(std::make_unique<Scratch>()) {}
DeformableWorkspace::~DeformableWorkspace() = default;
DeformableWorkspace::DeformableWorkspace(DeformableWorkspace&&) noexcept = default;
DeformableWorkspace& DeformableWorkspace::operator=(DeformableWorkspace&&) noexcept = default;

namespace
{
/// Tasks that a thread takes at once.
constexpr std::size_t kTasksAtOnce = 256;

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

void sortContacts(std::vector<DeformableContact>& contacts)
{
    const auto key = [](const DeformableContact& c)
    { return std::tie(c.time, c.kind, c.bodyA, c.bodyB, c.vertices); };
    std::vector<std::uint32_t> order(contacts.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::sort(order,
                      [&](std::uint32_t a, std::uint32_t b)
                      { return key(contacts[a]) < key(contacts[b]); });
    std::vector<DeformableContact> sorted;
    sorted.reserve(contacts.size());
    for (const std::uint32_t i : order)
    {
        sorted.push_back(contacts[i]);
    }
    contacts.swap(sorted);
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
            result.contacts.clear();
            result.status = m_isStopped ? ToiStatus::Stopped : ToiStatus::IterationLimit;
            result.time = 0.0;
            return result;
        }
        if (m_state.firstOnly)
        {
            std::erase_if(result.contacts,
                          [this](const DeformableContact& contact)
                          { return contact.time > m_state.earliest.load(); });
        }
        sortContacts(result.contacts);
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
        std::vector<FeatureSearch> searches;
        for (int i = 0; i < m_options.threads; ++i)
        {
            searches.emplace_back(m_state);
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
        for (FeatureSearch& search : searches)
        {
            result.counters.patchPairs += search.counters().patchPairs;
            result.counters.featurePairs += search.counters().featurePairs;
            result.counters.advanced += search.counters().advanced;
            result.contacts.insert(
                result.contacts.end(), search.contacts().begin(), search.contacts().end());
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
