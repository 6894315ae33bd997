#include "tools/grasp_cli/answers/trial_runs.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace bullet_ccd::tools
{
std::vector<grasp::TrialProtocol> protocolsNamed(const std::vector<std::string>& lists,
                                                 const std::string& option)
{
    std::vector<grasp::TrialProtocol> protocols;
    for (const std::string& list : lists)
    {
        std::istringstream names(list + ",");
        for (std::string name; std::getline(names, name, ',');)
        {
            if (name.empty())
            {
                throw std::invalid_argument(option + " " + list +
                                            ": a name is missing beside a comma: give one");
            }
            protocols.push_back(grasp::namedProtocol(name));
            const std::string& known = protocols.back().name;
            if (std::ranges::count(protocols, known, &grasp::TrialProtocol::name) > 1)
            {
                throw std::invalid_argument(option + " " + list + ": two protocols are called \"" +
                                            known + "\": drop one, or give it another name");
            }
        }
    }
    return protocols;
}

bool TrialRow::isDone() const
{
    return !error.empty() ||
           std::ranges::all_of(results,
                               [](const auto& result) {
                                   return result && result->outcome != grasp::TrialOutcome::Stopped;
                               });
}

std::vector<TrialRow> runTrials(const grasp::HandModel& hand,
                                const grasp::GraspObject& object,
                                std::span<const grasp::Grasp* const> grasps,
                                const std::vector<grasp::TrialProtocol>& protocols,
                                grasp::TrialOptions options,
                                int jobs,
                                const StopRequest& stop,
                                const JudgedModels& judged,
                                const std::function<void(const std::vector<TrialRow>&)>& ended,
                                const TrialWatch& watch)
{
    options.stop = stop.condition();
    std::vector<TrialRow> rows(grasps.size());
    for (TrialRow& row : rows)
    {
        row.results.resize(protocols.size());
    }
    const std::size_t count = grasps.size() * protocols.size();
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    const auto work = [&]
    {
        grasp::PenetrationCheck check(judged.hand, judged.object);
        while (!stop.isDue())
        {
            const std::size_t turn = next++;
            if (turn >= count)
            {
                return;
            }
            const std::size_t k = turn / protocols.size();
            const std::size_t p = turn % protocols.size();
            std::optional<grasp::TrialResult> result;
            std::string error;
            try
            {
                grasp::TrialOptions own = options;
                own.check = &check;
                if (watch)
                {
                    own.watch = watch(k, p);
                }
                result = grasp::runTrial(hand, object, *grasps[k], protocols[p], own);
            }
            catch (const std::exception& reason)
            {
                error = reason.what();
            }
            const std::lock_guard lock(mutex);
            if (result &&
                (result->outcome != grasp::TrialOutcome::Stopped || !result->pulls.empty()))
            {
                rows[k].results[p] = std::move(result);
            }
            else if (!error.empty())
            {
                rows[k].error = error;
            }
            if (ended)
            {
                ended(rows);
            }
        }
    };
    const std::size_t threads =
        jobs > 0 ? static_cast<std::size_t>(jobs) : std::thread::hardware_concurrency();
    {
        std::vector<std::jthread> others;
        for (std::size_t k = 1; k < std::min(threads, count); ++k)
        {
            others.emplace_back(work);
        }
        work();
    }
    // Grasps are begun in their order.
    const std::size_t begun = std::min<std::size_t>(next, count);
    rows.resize(protocols.empty() ? 0 : (begun + protocols.size() - 1) / protocols.size());
    return rows;
}
}  // namespace bullet_ccd::tools
