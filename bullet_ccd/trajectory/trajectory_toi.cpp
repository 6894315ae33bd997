#include "bullet_ccd/math/check.h"
#include "bullet_ccd/trajectory/trajectory.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <tbb/parallel_for.h>

namespace bullet_ccd
{
namespace
{
/// Calls answer(k, work) for k in [begin, end), in parallel if there is scratch for it. Each thread
/// takes the next number, so that they are begun in their order.
template <typename Answer>
void forEachSegment(std::size_t begin,
                    std::size_t end,
                    std::span<ToiWorkspace> work,
                    const Answer& answer)
{
    std::atomic<std::size_t> next = begin;
    const auto run = [&](std::size_t thread)
    {
        for (std::size_t k = next++; k < end; k = next++)
        {
            answer(k, work[thread]);
        }
    };
    const std::size_t threads = std::min(work.size(), end - begin);
    if (threads <= 1)
    {
        run(0);
        return;
    }
    tbb::parallel_for(std::size_t{0}, threads, run);
}

double secondsAt(const Trajectory& trajectory, std::size_t segment, double part)
{
    const double from = trajectory.times[segment];
    const double to = trajectory.times[segment + 1];
    return part == 1.0 ? to : from + part * (to - from);
}

void requireWork(std::span<ToiWorkspace> work)
{
    require(!work.empty(), "trajectory: there is no scratch memory: give one ToiWorkspace or more");
}

/// Any distance in a model is smaller [m].
constexpr double kFarthest = 1e12;

/// Segments that share what is known when they begin: enough for some threads, few enough that most
/// of a trajectory profits from what came before.
constexpr std::size_t kRound = 8;
}  // namespace

TrajectoryToiResult trajectoryToi(const ArticulatedBody& body,
                                  const Environment& environment,
                                  const Trajectory& trajectory,
                                  const ArticulatedToiOptions& options,
                                  std::span<ToiWorkspace> work)
{
    checkTrajectory(trajectory);
    requireWork(work);
    require(environment.movingCount() == 0,
            "trajectoryToi: an obstacle moves: all must rest while a trajectory is asked about");
    const std::size_t count = trajectory.segments.size();
    std::vector<ArticulatedToiResult> answers(count);
    std::atomic<std::size_t> earliest = count;  // segment that is not free
    forEachSegment(0,
                   count,
                   work,
                   [&](std::size_t k, ToiWorkspace& scratch)
                   {
                       if (k > earliest)
                       {
                           return;
                       }
                       ArticulatedBody moving = body;
                       moving.motion = &trajectory.segments[k];
                       answers[k] = articulatedToi(moving, environment, options, scratch);
                       if (answers[k].status != ToiStatus::Separated)
                       {
                           std::size_t known = earliest;
                           while (k < known && !earliest.compare_exchange_weak(known, k))
                           {
                           }
                       }
                   });
    const std::size_t last = earliest;
    TrajectoryToiResult result;
    result.time = trajectory.times.back();
    for (std::size_t k = 0; k < std::min(last + 1, count); ++k)
    {
        result.counters += answers[k].counters;
    }
    if (last < count)
    {
        result.status = answers[last].status;
        result.time = secondsAt(trajectory, last, answers[last].time);
        result.segment = static_cast<std::int32_t>(last);
        result.contacts = std::move(answers[last].contacts);
    }
    return result;
}

TrajectoryLeastDistance leastDistance(const ArticulatedBody& body,
                                      std::span<const RigidBody> obstacles,
                                      const Trajectory& trajectory,
                                      const LeastDistanceOptions& options,
                                      std::span<ToiWorkspace> work)
{
    checkTrajectory(trajectory);
    requireWork(work);
    const Environment environment(obstacles);
    const std::size_t count = trajectory.segments.size();
    std::vector<ArticulatedLeastDistance> answers(count);
    TrajectoryLeastDistance best;
    best.found = options.enough;
    best.distance = options.enough;
    best.seconds = trajectory.times.front();
    ToiCounters counters;
    int queries = 0;
    for (std::size_t begin = 0; begin < count && best.found > 0.0; begin += kRound)
    {
        if (options.stop.isDue())
        {
            best.status = gaveUp(best.status) ? best.status : ToiStatus::Stopped;
            best.distance = 0.0;  // nothing is known of what follows
            break;
        }
        const std::size_t end = std::min(begin + kRound, count);
        LeastDistanceOptions wanted = options;
        wanted.enough = std::min(best.found, kFarthest);
        forEachSegment(begin,
                       end,
                       work,
                       [&](std::size_t k, ToiWorkspace& scratch)
                       {
                           ArticulatedBody moving = body;
                           moving.motion = &trajectory.segments[k];
                           answers[k] = leastDistance(moving, environment, wanted, scratch);
                       });
        for (std::size_t k = begin; k < end; ++k)
        {
            const ArticulatedLeastDistance& answer = answers[k];
            counters.nodePairs += answer.counters.nodePairs;
            counters.trianglePairs += answer.counters.trianglePairs;
            counters.states += answer.counters.states;
            queries += answer.queries;
            // The first segment that gave up says why.
            const ToiStatus gaveUpBy = gaveUp(best.status) ? best.status : answer.status;
            // A segment in which nothing moves knows only that it was not asked for more.
            const double distance = answer.distance < kFarthest
                                        ? std::min(best.distance, answer.distance)
                                        : best.distance;
            if (answer.link != kNone && answer.found < best.found)
            {
                static_cast<ArticulatedLeastDistance&>(best) = answer;
                best.segment = static_cast<std::int32_t>(k);
                best.seconds = secondsAt(trajectory, k, answer.time);
            }
            best.distance = distance;
            best.status = gaveUp(gaveUpBy) ? gaveUpBy : best.status;
        }
    }
    best.counters = counters;
    best.queries = queries;
    return best;
}
}  // namespace bullet_ccd
