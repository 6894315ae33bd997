#include "tools/grasp_cli/answers/plan_trials.h"

#include "grasp/trial/refinement.h"
#include "tools/grasp_cli/answers/trial_runs.h"
#include "tools/support/progress_line.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
using grasp::Grasp;
using grasp::RejectReason;
using TryAll = std::function<std::vector<TrialRow>(const std::vector<Grasp>&)>;

/// Grasps that were tried, and what that came to.
struct TriedGrasps
{
    std::vector<Grasp> grasps;
    std::vector<TrialRow> rows;  ///< may end before the grasps

    [[nodiscard]] int held(std::size_t k) const
    {
        return static_cast<int>(std::ranges::count_if(
            rows[k].results,
            [](const auto& result)
            { return result && result->outcome == grasp::TrialOutcome::Held; }));
    }
};

/// Puts better ones in the place of those that failed, round by round: the hand goes where the
/// object went. Returns how many hold more than before.
std::size_t refineGrasps(int rounds,
                         const grasp::PlannerOptions& options,
                         std::span<const RigidBody> obstacles,
                         const PlanRun& run,
                         const StopRequest& stop,
                         const TryAll& tryAll,
                         TriedGrasps& tried)
{
    std::set<std::size_t> improved;
    const auto isHeld = [](const std::optional<grasp::TrialResult>& result)
    { return !result || result->outcome == grasp::TrialOutcome::Held; };
    TriedGrasps last = tried;
    std::vector<std::size_t> indices(tried.rows.size());
    std::iota(indices.begin(), indices.end(), std::size_t{0});
    for (int round = 0; round < rounds && !stop.isDue(); ++round)
    {
        TriedGrasps next;
        std::vector<std::size_t> of;
        for (std::size_t k = 0; k < last.rows.size(); ++k)
        {
            const auto& results = last.rows[k].results;
            const auto lost = std::ranges::find_if_not(results, isHeld);
            if (lost == results.end())
            {
                continue;
            }
            const Grasp refined = refinedGrasp(run.hand.hand,
                                               run.object.object,
                                               last.grasps[k],
                                               **lost,
                                               options,
                                               closingEngine(options.engine, obstacles)(),
                                               obstacles);
            if (refined.reject == RejectReason::None)
            {
                next.grasps.push_back(refined);
                of.push_back(indices[k]);
            }
        }
        next.rows = tryAll(next.grasps);
        for (std::size_t k = 0; k < next.rows.size(); ++k)
        {
            if (next.rows[k].isDone() && next.held(k) > tried.held(of[k]))
            {
                tried.grasps[of[k]] = next.grasps[k];
                tried.rows[of[k]] = next.rows[k];
                improved.insert(of[k]);
            }
        }
        last = std::move(next);
        indices = std::move(of);
    }
    return improved.size();
}
}  // namespace

TriedCount tryGrasps(const PlanTrials& trials,
                     std::span<const RigidBody> obstacles,
                     bool quiet,
                     const StopRequest& stop,
                     PlanRun& run,
                     grasp::GraspRun& description)
{
    const std::vector<grasp::TrialProtocol> protocols = protocolsNamed(trials.protocols, "--trial");
    const grasp::PlannerOptions& options = description.options;
    const std::size_t count =
        std::min(forceClosures(run.grasps), static_cast<std::size_t>(trials.tried));
    const auto tryAll = [&](const std::vector<Grasp>& grasps)
    {
        std::vector<Grasp> recorded;  // so that grasp trial gives the same bits
        std::ranges::transform(grasps, std::back_inserter(recorded), grasp::asRecorded);
        std::vector<const Grasp*> chosen;
        for (const Grasp& grasp : recorded)
        {
            chosen.push_back(&grasp);
        }
        std::optional<ProgressLine> progress;
        if (!quiet)
        {
            progress.emplace(grasps.size() * protocols.size(), "trials");
        }
        std::size_t ended = 0;
        return runTrials(
            run.hand.hand,
            run.object.object,
            chosen,
            protocols,
            {.squeeze = *description.squeeze, .up = options.approach.up, .brief = trials.brief},
            options.jobs,
            stop,
            {run.hand.hand, run.object.object},
            [&](const std::vector<TrialRow>&)
            {
                if (progress)
                {
                    progress->show(++ended);
                }
            });
    };
    TriedGrasps tried;
    tried.grasps.assign(run.grasps.begin(),
                        run.grasps.begin() + static_cast<std::ptrdiff_t>(count));
    tried.rows = tryAll(tried.grasps);
    TriedCount total{.count = count};
    total.improved = refineGrasps(trials.refine, options, obstacles, run, stop, tryAll, tried);
    std::map<std::int64_t, int> held;
    for (std::size_t k = 0; k < tried.rows.size(); ++k)
    {
        const TrialRow& row = tried.rows[k];
        const std::int64_t candidate = run.grasps[k].candidate;
        if (!row.error.empty())
        {
            throw std::runtime_error(row.error);
        }
        run.grasps[k] = tried.grasps[k];
        total.done += row.isDone() ? 1 : 0;
        held[candidate] = tried.held(k);
        for (std::size_t p = 0; p < protocols.size(); ++p)
        {
            if (const std::optional<grasp::TrialResult>& result = row.results[p])
            {
                description.trials[candidate].push_back(
                    {.protocol = protocols[p].name,
                     .outcome = toString(result->outcome),
                     .reason = result->reason,
                     .held = result->outcome == grasp::TrialOutcome::Held,
                     .slip = result->slip,
                     .turn = result->turn});
            }
        }
    }
    std::stable_sort(run.grasps.begin(),
                     run.grasps.begin() + static_cast<std::ptrdiff_t>(tried.rows.size()),
                     [&](const Grasp& a, const Grasp& b)
                     { return held[a.candidate] > held[b.candidate]; });
    return total;
}
}  // namespace bullet_ccd::tools
