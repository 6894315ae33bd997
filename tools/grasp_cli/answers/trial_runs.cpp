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
        }
    }
    return protocols;
}

TrialRows runTrials(const grasp::HandModel& hand,
                    const grasp::GraspObject& object,
                    std::span<const grasp::Grasp* const> grasps,
                    const std::vector<grasp::TrialProtocol>& protocols,
                    const grasp::TrialOptions& options,
                    int jobs,
                    const StopRequest& stop)
{
    TrialRows rows(grasps.size());
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    std::exception_ptr error;
    const auto work = [&]
    {
        try
        {
            while (!stop.isDue())
            {
                const std::size_t k = next++;
                if (k >= grasps.size())
                {
                    return;
                }
                std::vector<grasp::TrialResult> row;
                for (const grasp::TrialProtocol& protocol : protocols)
                {
                    row.push_back(grasp::runTrial(hand, object, *grasps[k], protocol, options));
                }
                rows[k] = std::move(row);
            }
        }
        catch (...)
        {
            const std::lock_guard lock(mutex);
            error = std::current_exception();
            next = grasps.size();
        }
    };
    const std::size_t threads =
        jobs > 0 ? static_cast<std::size_t>(jobs) : std::thread::hardware_concurrency();
    {
        std::vector<std::jthread> others;
        for (std::size_t k = 1; k < std::min(threads, grasps.size()); ++k)
        {
            others.emplace_back(work);
        }
        work();
    }
    if (error)
    {
        std::rethrow_exception(error);
    }
    while (!rows.empty() && rows.back().empty())
    {
        rows.pop_back();
    }
    return rows;
}
}  // namespace bullet_ccd::tools
