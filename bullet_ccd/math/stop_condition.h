/// When a query is to end although it is not done.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace bullet_ccd
{
/// A query ends at the deadline, or when another thread or a signal handler cancels it, whichever
/// comes first; the default is neither. Queries look at it at their beginning and then every few
/// hundred pairs of nodes, that is several times a millisecond.
struct StopCondition
{
    using Clock = std::chrono::steady_clock;

    Clock::time_point deadline = Clock::time_point::max();
    /// Not null: the query ends soon after this has become true. It must outlive the query.
    const std::atomic<bool>* isCancelled = nullptr;

    /// False if there is nothing to look at.
    [[nodiscard]] bool isGiven() const
    {
        return isCancelled != nullptr || deadline != Clock::time_point::max();
    }
    /// Thread-safe.
    [[nodiscard]] bool isDue() const
    {
        return (isCancelled != nullptr && isCancelled->load(std::memory_order_relaxed)) ||
               (deadline != Clock::time_point::max() && Clock::now() >= deadline);
    }
};

/// Thrown by queries whose answer says nothing of having been stopped.
class QueryStopped : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// A deadline that many seconds from now, or now if they are below 0. Without one if that is more
/// than thirty years. Throws std::invalid_argument if they are NaN.
[[nodiscard]] inline StopCondition stopAfter(double seconds)
{
    if (std::isnan(seconds))
    {
        throw std::invalid_argument("stopAfter: the time is NaN: give seconds");
    }
    constexpr double kForever = 1e9;
    if (seconds >= kForever)
    {
        return {};
    }
    const std::chrono::duration<double> wait(std::max(seconds, 0.0));
    return {.deadline = StopCondition::Clock::now() +
                        std::chrono::duration_cast<StopCondition::Clock::duration>(wait)};
}
}  // namespace bullet_ccd
