/// Scenes and methods of the articulated chart.
#pragma once

#include "benchmarks/support/chart.h"

#include <filesystem>
#include <string>

namespace bullet_ccd::benchmarks
{
struct HumanChartOptions
{
    std::filesystem::path data;
    bool quick = false;  ///< 12 queries a scene
    int repeats = 3;     ///< of fast methods; the median counts
};

/// The queries of one recorded motion at which nothing intersects at the start, with the whole
/// query, without its stages, with other bounds, rigidToi() on each pair, and FCL's samples of all
/// links. Truths are FCL's, from our time at a tolerance of 1e-9 m on. The methods share ownership
/// of what they need. Throws std::logic_error in a build without FCL.
[[nodiscard]] ChartScene makeHumanChartScene(const std::string& motion,
                                             const HumanChartOptions& options);
}  // namespace bullet_ccd::benchmarks
