/// Calls that may not return, each with a time limit.
#pragma once

#include "benchmarks/support/chart.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Answers of calls 0 .. count - 1, made one after the other in a child process; one that takes
/// longer than `secondsEach` is ended and timedOut. Throws std::runtime_error if no process can be
/// made.
[[nodiscard]] std::vector<ChartAnswer> runWithLimit(
    std::size_t count, double secondsEach, const std::function<ChartAnswer(std::size_t)>& call);
}  // namespace bullet_ccd::benchmarks
