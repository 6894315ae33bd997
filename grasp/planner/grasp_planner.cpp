#include "grasp/planner/grasp_planner.h"

#include "bullet_ccd/math/check.h"
#include "grasp/planner/plan_candidate.h"

#include <algorithm>
#include <optional>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
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
    require(options.friction > 0.0, "planGrasps: friction must be positive");
    require(options.coneEdges >= 3, "planGrasps: a friction cone needs three edges or more");
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

void addVolumes(std::span<Grasp> grasps, const GraspObject& object, const PlannerOptions& options)
{
    const std::size_t count =
        std::min(grasps.size(), static_cast<std::size_t>(std::max(0, options.volumes)));
    tbb::parallel_for(
        std::size_t{0}, count, [&](std::size_t k) { addVolume(grasps[k], object, options); });
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
                              const PlanProgress& progress,
                              std::span<const RigidBody> obstacles)
{
    checkOptions(options);
    std::vector<Grasp> grasps(static_cast<std::size_t>(options.candidates));
    const int jobs = options.jobs > 0 ? options.jobs : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(jobs));
    tbb::enumerable_thread_specific<std::optional<Worker>> workers;
    tbb::task_arena arena(jobs);
    arena.execute(
        [&]
        {
            const ObjectShape shape = objectShape(object);
            const Surroundings surroundings = surroundingsOf(hand, obstacles);
            // Every candidate has its own place and its own random numbers, so neither the order
            // nor the number of threads matters.
            tbb::parallel_for(
                std::int64_t{0},
                options.candidates,
                [&](std::int64_t number)
                {
                    std::optional<Worker>& worker = workers.local();
                    if (!worker)
                    {
                        worker.emplace(Worker{.close = makeCloseHand(),
                                              .check = PenetrationCheck(hand, object)});
                    }
                    const ApproachCandidate candidate = sampleApproach(
                        hand, object, shape, options.seed, number, options.candidates);
                    worker->environment.reset(bodiesNear(candidate, object, surroundings));
                    CandidateContext context{.hand = hand,
                                             .object = object,
                                             .environment = worker->environment,
                                             .options = options,
                                             .close = worker->close,
                                             .check = worker->check,
                                             .work = worker->work};
                    Grasp& grasp = grasps[static_cast<std::size_t>(number)];
                    grasp = planCandidate(candidate, context);
                    if (progress)
                    {
                        progress(grasp);
                    }
                });
            std::sort(grasps.begin(), grasps.end(), ranksBefore);
            addVolumes(grasps, object, options);
        });
    return grasps;
}
}  // namespace bullet_ccd::grasp
