/// Clock, memory and statistics of the benchmarks.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <malloc.h>
#include <numeric>
#include <span>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Processor time of a call on this thread: what other programs do on the machine is not counted,
/// but for what they take from its caches.
template <typename Call>
double microsecondsOf(const Call& call)
{
    const auto now = []
    {
        timespec time{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
    };
    const double begin = now();
    call();
    return now() - begin;
}

/// Wall time of a call that may use threads of its own.
template <typename Call>
double wallMicrosecondsOf(const Call& call)
{
    const auto begin = std::chrono::steady_clock::now();
    call();
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
    return time.count();
}

/// What the program holds.
inline double heldMegabytes()
{
    const struct mallinfo2 held = mallinfo2();
    return 1e-6 * double(held.uordblks + held.hblkhd);
}

/// Keeps a result alive so that its computation is not optimised away.
inline void keep(double value)
{
    const volatile double kept = value;
    static_cast<void>(kept);
}

/// 0 for none.
inline double medianOf(std::vector<double> values)
{
    if (values.empty())
    {
        return 0.0;
    }
    std::ranges::sort(values);
    const std::size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

inline double sumOf(std::span<const double> values)
{
    return std::accumulate(values.begin(), values.end(), 0.0);
}

/// 0 for none.
inline double meanOf(std::span<const double> values)
{
    return values.empty() ? 0.0 : sumOf(values) / static_cast<double>(values.size());
}

/// One way to answer the queries of a set.
struct TimedMethod
{
    std::size_t queries = 0;
    int passes = 1;
    std::function<void(std::size_t)> ask;
    std::function<void(std::size_t)> prepare = nullptr;  ///< not timed
};

/// Microseconds of every query by every method, the median over the passes. The methods take turns,
/// pass by pass, so that what slows the machine down slows down all of them.
inline std::vector<std::vector<double>> timeInTurns(std::span<const TimedMethod> methods)
{
    std::vector<std::vector<std::vector<double>>> times(methods.size());
    bool isDone = false;
    for (int pass = 0; !isDone; ++pass)
    {
        isDone = true;
        for (std::size_t m = 0; m < methods.size(); ++m)
        {
            const TimedMethod& method = methods[m];
            times[m].resize(method.queries);
            for (std::size_t i = 0; i < method.queries && pass < method.passes; ++i)
            {
                if (method.prepare)
                {
                    method.prepare(i);
                }
                times[m][i].push_back(microsecondsOf([&] { method.ask(i); }));
            }
            isDone = isDone && pass + 1 >= method.passes;
        }
    }
    std::vector<std::vector<double>> medians(methods.size());
    for (std::size_t m = 0; m < methods.size(); ++m)
    {
        std::ranges::transform(times[m], std::back_inserter(medians[m]), medianOf);
    }
    return medians;
}
}  // namespace bullet_ccd::benchmarks
