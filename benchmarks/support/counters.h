/// What articulated queries did, as a row of a table.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
/// Means over the queries; "space" and "time" are the shares of the pairs that were culled by it
/// [%].
inline nlohmann::json rowOf(const ArticulatedCounters& sum, double queries)
{
    const auto mean = [&](std::int64_t number)
    { return static_cast<double>(number) / std::max(1.0, queries); };
    const auto share = [&](std::int64_t number)
    { return 100.0 * static_cast<double>(number) / std::max(1.0, static_cast<double>(sum.pairs)); };
    return {{"pairs", mean(sum.pairs)},
            {"space", share(sum.culledBySpace)},
            {"time", share(sum.culledByTime)},
            {"nodes", mean(sum.nodePairs)},
            {"triangles", mean(sum.trianglePairs)},
            {"states", mean(sum.states)},
            {"halved", mean(sum.subdivisions)}};
}

/// Columns for these.
inline constexpr const char* kCounterColumns =
    "pairs:>6.0f|space %=space:>7.1f|time %=time:>7.2f|nodes:>7.0f|triang.=triangles:>7.1f|"
    "states:>6.0f|halved:>6.2f";
}  // namespace bullet_ccd::benchmarks
