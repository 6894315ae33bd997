#include "bullet_ccd/deformable/deformable_toi.h"

#include "bullet_ccd/deformable/feature_search.h"
#include "bullet_ccd/deformable/pursue.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
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

/// A body where a sweep along x has it.
struct SweptBody
{
    Eigen::AlignedBox3d box;  ///< of the whole step, widened by half of what is looked for
    std::size_t body = 0;
};

/// All pairs of bodies whose boxes come near, and of one body with itself: by a sweep, so that many
/// bodies that are far from each other cost little.
void pairSurfaces(std::span<const DeformableBody> bodies,
                  const DeformableOptions& options,
                  std::uint8_t idle,
                  std::vector<SurfacePair>& pairs)
{
    pairs.clear();
    const auto addPair = [&](std::size_t i, std::size_t j)
    {
        const DeformableSurface::Data& a = bodies[i].surface->data();
        const DeformableSurface::Data& b = bodies[j].surface->data();
        if ((a.idle(0) & b.idle(0) & idle) != 0 || (i == j && !bodies[i].selfCollision) ||
            (options.isPairExempt &&
             options.isPairExempt(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j))))
        {
            return;
        }
        const double separation =
            options.minimumSeparation + bodies[i].deviation + bodies[j].deviation;
        pairs.push_back(surfacePair(a, b, separation, separation + options.tolerance));
        pairs.back().bodyA = static_cast<std::int32_t>(i);
        pairs.back().bodyB = static_cast<std::int32_t>(j);
        pairs.back().idle = idle;
    };
    std::vector<SweptBody> swept;
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        Eigen::AlignedBox3d box = bodies[i].surface->data().bounds;
        const double reach =
            bodies[i].deviation + 0.5 * (options.minimumSeparation + options.tolerance);
        const double rounding =
            1e-15 * box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
        const Eigen::Vector3d wider = Eigen::Vector3d::Constant(1.0001 * reach + rounding);
        swept.push_back({{box.min() - wider, box.max() + wider}, i});
    }
    std::ranges::sort(swept,
                      [](const SweptBody& a, const SweptBody& b)
                      { return a.box.min().x() < b.box.min().x(); });
    std::vector<const SweptBody*> open;  // that the sweep has not left behind
    for (const SweptBody& now : swept)
    {
        std::erase_if(
            open, [&](const SweptBody* other) { return other->box.max().x() < now.box.min().x(); });
        open.push_back(&now);
        for (const SweptBody* other : open)
        {
            if (other->box.intersects(now.box))
            {
                addPair(std::min(other->body, now.body), std::max(other->body, now.body));
            }
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

/// The order of contacts that begin at the same time.
auto orderOf(const DeformableContact& c)
{
    return std::tie(c.kind, c.bodyA, c.bodyB, c.vertices);
}

bool isBefore(const DeformableContact& a, const DeformableContact& b)
{
    return a.time != b.time ? a.time < b.time : orderOf(a) < orderOf(b);
}

/// What all threads have found until `latest`, in order.
void putInOrder(const std::vector<std::vector<DeformableContact>>& found,
                double latest,
                int threads,
                std::vector<DeformableContact>& sorted)
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
    const auto isLess = [](const Place& a, const Place& b)
    { return a.time != b.time ? a.time < b.time : orderOf(*a.contact) < orderOf(*b.contact); };
    if (threads == 1)
    {
        std::ranges::sort(order, isLess);
    }
    else
    {
        tbb::task_arena arena(threads);
        arena.execute([&] { tbb::parallel_sort(order.begin(), order.end(), isLess); });
    }
    sorted.clear();
    sorted.reserve(order.size());
    for (const Place& place : order)
    {
        sorted.push_back(*place.contact);
    }
}

/// Removes the contacts of features of which a vertex goes another way than in the step before.
void removeChanged(std::span<const DeformableBody> bodies, std::vector<DeformableContact>& contacts)
{
    std::vector<std::vector<bool>> hasChanged(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        const DeformableSurface::Data& data = bodies[i].surface->data();
        hasChanged[i].resize(data.isUnchanged ? 0 : data.meshVertices);
        for (std::size_t v = 0; v < data.vertexIdle.size() && !data.isUnchanged; ++v)
        {
            hasChanged[i][static_cast<std::size_t>(data.meshVertex[v])] =
                (data.vertexIdle[v] & kUnchanged) == 0;
        }
    }
    std::erase_if(
        contacts,
        [&](const DeformableContact& contact)
        {
            const std::size_t ofA = contact.kind == ElementaryKind::VertexFace ? 1 : 2;
            for (std::size_t k = 0; k < 4; ++k)
            {
                const std::vector<bool>& changes =
                    hasChanged[static_cast<std::size_t>(k < ofA ? contact.bodyA : contact.bodyB)];
                if (!changes.empty() && changes[static_cast<std::size_t>(contact.vertices[k])])
                {
                    return true;
                }
            }
            return false;
        });
}

enum class Wanted : std::uint8_t
{
    All,
    First,
    OfChanged,  ///< of features of which a vertex goes another way than in the step before
};

class DeformableQuery
{
public:
    DeformableQuery(std::span<const DeformableBody> bodies,
                    const DeformableOptions& options,
                    Wanted wanted,
                    DeformableWorkspace::Scratch& scratch)
        : m_options(options), m_scratch(scratch)
    {
        checkQuery(bodies, options);
        pairSurfaces(bodies,
                     options,
                     wanted == Wanted::OfChanged ? kRests | kUnchanged : kRests,
                     scratch.surfaces);
        m_state.surfaces = scratch.surfaces;
        m_state.options = &options;
        m_state.firstOnly = wanted == Wanted::First;
    }

    [[nodiscard]] DeformableResult run()
    {
        DeformableResult result;
        run(result);
        return result;
    }

    /// The same in the memory of an earlier result.
    void run(DeformableResult& result)
    {
        result.contacts.clear();
        result.counters = {};
        if (!findTasks() || !examineTasks(result))
        {
            result.status = m_isStopped ? ToiStatus::Stopped : ToiStatus::IterationLimit;
            result.time = 0.0;
            return;
        }
        const double latest = m_state.firstOnly ? m_state.earliest.load() : 1.0;
        putInOrder(m_scratch.found, latest, m_options.threads, result.contacts);
        summarise(result);
    }

    static void summarise(DeformableResult& result)
    {
        const bool isAny = !result.contacts.empty();
        result.status = isAny ? result.contacts.front().status : ToiStatus::Separated;
        result.time = isAny ? result.contacts.front().time : 1.0;
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
    return DeformableQuery(bodies, options, Wanted::All, work.scratch()).run();
}

void updateContacts(std::span<const DeformableBody> bodies,
                    const DeformableOptions& options,
                    DeformableWorkspace& work,
                    DeformableResult& result)
{
    const auto isUnknown = [](const DeformableResult& answer)
    { return gaveUp(answer.status) && answer.contacts.empty(); };
    if (isUnknown(result))
    {
        DeformableQuery(bodies, options, Wanted::All, work.scratch()).run(result);
        return;
    }
    DeformableResult update =
        DeformableQuery(bodies, options, Wanted::OfChanged, work.scratch()).run();
    if (isUnknown(update))
    {
        result = std::move(update);
        return;
    }
    removeChanged(bodies, result.contacts);
    const auto kept = static_cast<std::ptrdiff_t>(result.contacts.size());
    result.contacts.insert(result.contacts.end(), update.contacts.begin(), update.contacts.end());
    std::inplace_merge(
        result.contacts.begin(), result.contacts.begin() + kept, result.contacts.end(), isBefore);
    result.counters = update.counters;
    DeformableQuery::summarise(result);
}

DeformableResult deformableToi(std::span<const DeformableBody> bodies,
                               const DeformableOptions& options,
                               DeformableWorkspace& work)
{
    return DeformableQuery(bodies, options, Wanted::First, work.scratch()).run();
}

namespace
{
RigidStep stepBetween(const TriangleMesh& mesh,
                      const Eigen::Isometry3d& X_W0,
                      const Eigen::Isometry3d& X_W1,
                      const AccelerationBound& bound)
{
    require(X_W0.matrix().allFinite() && X_W1.matrix().allFinite(),
            "step of a rigid mesh: the motion is not finite: give finite poses and velocities");
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
}  // namespace

RigidStep rigidStep(const TriangleMesh& mesh, const RigidMotion& motion)
{
    return stepBetween(mesh, motion.at(0.0).X_W, motion.at(1.0).X_W, motion.accelerationBound());
}

RigidStep linkStep(const TriangleMesh& mesh,
                   const KinematicTree& tree,
                   const JointMotion& motion,
                   std::int32_t link)
{
    return stepBetween(mesh,
                       linkStateAt(tree, motion, kNone, link, 0.0).X_W,
                       linkStateAt(tree, motion, kNone, link, 1.0).X_W,
                       linkAccelerationBound(tree, motion, kNone, link));
}
}  // namespace bullet_ccd
