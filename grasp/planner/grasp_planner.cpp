#include "grasp/planner/grasp_planner.h"

#include "bullet_ccd/math/check.h"
#include "grasp/planner/plan_candidate.h"
#include "grasp/planner/source_schedule.h"
#include "grasp/planner/weight_margin.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace bullet_ccd::grasp
{
namespace
{
/// What a thread keeps from candidate to candidate.
struct Worker
{
    CloseHand close;
    PenetrationCheck check;
    Environment environment{};
    ToiWorkspace work{};
};

/// Hands out the candidates that are not known yet, in the order of their numbers.
class Queue
{
public:
    Queue(const PlannerOptions& options, const PlanExtras& extras)
        : m_timeLimit(options.timeLimit), m_stop(extras.stop), m_start(Clock::now())
    {
        std::vector<char> isKnown(static_cast<std::size_t>(options.candidates), 0);
        for (const Grasp& grasp : extras.known)
        {
            require(grasp.candidate >= 0 && grasp.candidate < options.candidates &&
                        isKnown[static_cast<std::size_t>(grasp.candidate)] == 0,
                    "planGrasps: a known candidate is there twice or has no number of this plan");
            isKnown[static_cast<std::size_t>(grasp.candidate)] = 1;
        }
        for (std::size_t number = 0; number < isKnown.size(); ++number)
        {
            if (isKnown[number] == 0)
            {
                m_numbers.push_back(static_cast<std::int64_t>(number));
            }
        }
    }

    [[nodiscard]] std::size_t size() const { return m_numbers.size(); }
    [[nodiscard]] std::int64_t number(std::size_t turn) const { return m_numbers[turn]; }
    /// So many turns were given.
    [[nodiscard]] std::size_t begun() const { return m_begun; }

    /// The next turn, unless there is none, no time left, or the caller wants to stop. Thread-safe:
    /// the clock is read and the turn given as one, so that no later turn is given once one was
    /// refused.
    [[nodiscard]] std::optional<std::size_t> begin()
    {
        const std::scoped_lock lock(m_mutex);
        const std::chrono::duration<double> elapsed = Clock::now() - m_start;
        const bool isLate = m_timeLimit > 0.0 && elapsed.count() >= m_timeLimit;
        const bool isOver = isLate || (m_stop && m_stop());
        if (m_begun == m_numbers.size() || (isOver && m_begun > 0))
        {
            return std::nullopt;
        }
        return m_begun++;
    }

private:
    using Clock = std::chrono::steady_clock;

    std::vector<std::int64_t> m_numbers;
    double m_timeLimit = 0.0;
    const std::function<bool()>& m_stop;
    Clock::time_point m_start;
    std::size_t m_begun = 0;
    std::mutex m_mutex;
};

Surroundings surroundingsOf(const HandModel& hand, std::span<const RigidBody> obstacles)
{
    Surroundings surroundings{.obstacles = obstacles};
    if (!obstacles.empty())
    {
        for (const Preshape& preshape : hand.preshapes)
        {
            surroundings.boxes.push_back(sweptBoxes(hand, preshape.positions));
        }
    }
    return surroundings;
}

void checkOptions(const PlannerOptions& options)
{
    require(options.candidates > 0, "planGrasps: at least one candidate is needed");
    require(options.jobs >= 0, "planGrasps: jobs must not be negative");
    require(options.timeLimit >= 0.0, "planGrasps: the time limit must not be negative");
    checkApproachOptions(options.approach);
    require(options.friction > 0.0, "planGrasps: friction must be positive");
    require(!options.mass || *options.mass > 0.0, "planGrasps: the mass must be positive");
    require(options.coneEdges == 0 || options.coneEdges >= 3,
            "planGrasps: a friction pyramid needs three edges or more; 0 takes exact cones");
    require(options.closing.tolerance > 0.0, "planGrasps: the tolerance must be positive");
    require(options.closing.contactThreshold >= options.closing.tolerance,
            "planGrasps: the contact threshold must not be below the tolerance");
}

/// 0: force closures, 1: other grasps, 2: rejected before there was a grasp.
int rankGroup(const Grasp& grasp)
{
    switch (grasp.reject)
    {
        case RejectReason::None:
            return 0;
        case RejectReason::NoForceClosure:
            return 1;
        default:
            return 2;
    }
}

/// Volumes belong to ranks, and ranks may have changed.
void addKnown(std::vector<Grasp>& grasps, std::span<const Grasp> known)
{
    for (const Grasp& grasp : known)
    {
        grasps.push_back(grasp);
        grasps.back().quality.volume = 0.0;
    }
}

/// Candidates that are not known before one of this number.
std::size_t turnsBefore(const Queue& queue, std::int64_t number)
{
    std::size_t turn = 0;
    while (turn < queue.size() && queue.number(turn) < number)
    {
        ++turn;
    }
    return turn;
}

void addVolumes(std::span<Grasp> grasps, const GraspObject& object, const PlannerOptions& options)
{
    const std::size_t count =
        std::min(grasps.size(), static_cast<std::size_t>(std::max(0, options.volumes)));
    tbb::parallel_for(
        std::size_t{0}, count, [&](std::size_t k) { addVolume(grasps[k], object, options); });
}

void addLargestMasses(std::span<Grasp> grasps,
                      const HandModel& hand,
                      const GraspObject& object,
                      const PlannerOptions& options)
{
    tbb::parallel_for(
        std::size_t{0},
        grasps.size(),
        [&](std::size_t k)
        {
            Grasp& grasp = grasps[k];
            if (grasp.reject == RejectReason::None)
            {
                grasp.quality.largestMass = largestMassHeld(
                    hand, object, grasp, options.friction, pyramidEdges(options), options.efforts);
            }
        });
}

bool ranksBefore(const Grasp& a, const Grasp& b)
{
    const int groupA = rankGroup(a);
    const int groupB = rankGroup(b);
    if (groupA != groupB)
    {
        return groupA < groupB;
    }
    if (groupA < 2 && a.quality.epsilon != b.quality.epsilon)
    {
        return a.quality.epsilon > b.quality.epsilon;
    }
    return a.candidate < b.candidate;
}
}  // namespace

std::vector<Grasp> planGrasps(const HandModel& hand,
                              const GraspObject& object,
                              const PlannerOptions& options,
                              const MakeCloseHand& makeCloseHand,
                              const PlanExtras& extras)
{
    checkOptions(options);
    Queue queue(options, extras);
    std::vector<Grasp> planned(queue.size());
    std::vector<char> held(static_cast<std::size_t>(options.candidates), 0);
    for (const Grasp& grasp : extras.known)
    {
        held[static_cast<std::size_t>(grasp.candidate)] = grasp.reject == RejectReason::None;
    }
    const int jobs = options.jobs > 0 ? options.jobs : tbb::info::default_concurrency();
    tbb::enumerable_thread_specific<std::optional<Worker>> workers;
    tbb::task_arena arena(jobs);
    arena.execute(
        [&]
        {
            ApproachShapes shapes = approachShapes(hand, object);
            shapes.widestOnly = fingersAreCoupled(hand) && extras.obstacles.empty();
            const Surroundings surroundings = surroundingsOf(hand, extras.obstacles);
            const bool isMixed = options.approach.source == ApproachSource::Mixed;
            SourceSchedule schedule(fittingPreshapes(shapes), options.candidates);
            const auto draw = [&](std::int64_t number)
            {
                return isMixed ? sampleApproach(hand,
                                                object,
                                                shapes,
                                                options.seed,
                                                number,
                                                options.candidates,
                                                schedule.turn(number),
                                                options.approach)
                               : sampleApproach(hand,
                                                object,
                                                shapes,
                                                options.seed,
                                                number,
                                                options.candidates,
                                                options.approach);
            };
            const auto planNext = [&]
            {
                const std::optional<std::size_t> turn = queue.begin();
                if (!turn)
                {
                    return;
                }
                std::optional<Worker>& worker = workers.local();
                if (!worker)
                {
                    worker.emplace(
                        Worker{.close = makeCloseHand(), .check = PenetrationCheck(hand, object)});
                }
                const ApproachCandidate candidate = draw(queue.number(*turn));
                const std::vector<RigidBody> bodies = bodiesNear(candidate, object, surroundings);
                const auto near = static_cast<std::int64_t>(bodies.size()) - 1;
                worker->environment.reset(bodies);
                CandidateContext context{.hand = hand,
                                         .object = object,
                                         .environment = worker->environment,
                                         .options = options,
                                         .close = worker->close,
                                         .check = worker->check,
                                         .work = worker->work};
                Grasp& grasp = planned[*turn];
                grasp = planCandidate(candidate, context);
                grasp.obstaclesInReach = near;
                if (grasp.reject == RejectReason::None && extras.reach && !extras.reach(grasp.X_WH))
                {
                    grasp.reject = RejectReason::OutOfReach;
                }
                held[static_cast<std::size_t>(grasp.candidate)] =
                    grasp.reject == RejectReason::None;
                if (extras.progress)
                {
                    extras.progress(grasp);
                }
            };
            // Every candidate of a block has its own place and its own random numbers, so neither
            // the order nor the number of threads matters. Without a schedule all is one block.
            for (std::int64_t end = 0; end < options.candidates;)
            {
                if (isMixed)
                {
                    schedule.extend(held);
                }
                end = isMixed ? schedule.end() : options.candidates;
                const std::size_t first = queue.begun();
                const std::size_t last = turnsBefore(queue, end);
                tbb::parallel_for(first, last, [&](std::size_t) { planNext(); });
                if (queue.begun() < last)
                {
                    break;  // late, or stopped
                }
            }
            planned.resize(queue.begun());
            addKnown(planned, extras.known);
            std::sort(planned.begin(), planned.end(), ranksBefore);
            addVolumes(planned, object, options);
            addLargestMasses(planned, hand, object, options);
        });
    return planned;
}
}  // namespace bullet_ccd::grasp
