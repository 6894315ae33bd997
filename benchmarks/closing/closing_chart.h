/// Scenes and methods of the chart of closing hands.
#pragma once

#include "benchmarks/support/chart.h"

#include <filesystem>
#include <string>

namespace bullet_ccd::benchmarks
{
struct ClosingChartOptions
{
    std::filesystem::path data;  ///< with hands/ and objects/
    int candidates = 20;
    int repeats = 3;  ///< of ours; the median counts
};

/// A hand and what it grasps.
struct ClosingPair
{
    std::string name;
    std::string hand;    ///< URDF file below hands/, without its ending
    std::string object;  ///< file below objects/
};
[[nodiscard]] const std::vector<ClosingPair>& closingPairs();

/// Approach and closing of the planner's candidates: ours at several tolerances, the discrete
/// baseline in steps of several sizes on our hierarchies and on FCL.
///
/// Errors are those of the posture: the largest difference of a joint [rad], of sliding ones ten
/// times that [m]. The reference is in between of two closings that share nothing but the hand:
/// ours at a tolerance of 1e-9 m and overlap tests in steps of 0.001 rad, bisected to the same gap,
/// by FCL where it is present. Candidates at which the two differ by more than 1e-6 rad are left
/// out for all methods; the title says how many.
[[nodiscard]] ChartScene makeClosingScene(const ClosingPair& pair,
                                          const ClosingChartOptions& options);
}  // namespace bullet_ccd::benchmarks
