/// Clock and statistics of the benchmarks.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
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

/// The value that this share of all is not above, 0 <= share <= 1; 0 for none.
inline double quantileOf(std::vector<double> values, double share)
{
    if (values.empty())
    {
        return 0.0;
    }
    std::ranges::sort(values);
    const double last = static_cast<double>(values.size() - 1);
    return values[static_cast<std::size_t>(std::lround(std::ceil(share * last - 1e-9)))];
}

/// Mean over queries of the median over repeats; 0 for none.
inline double meanOfMedians(std::span<const std::vector<double>> times)
{
    double sum = 0.0;
    for (const std::vector<double>& repeats : times)
    {
        sum += medianOf(repeats);
    }
    return times.empty() ? 0.0 : sum / static_cast<double>(times.size());
}
}  // namespace bullet_ccd::benchmarks
