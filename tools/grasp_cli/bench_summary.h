/// Tables of what `grasp bench` found, and whether it is good.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct BenchSummary
{
    std::string text;
    bool good = true;
};

/// Of rows of benchClosing(): a line a hand.
[[nodiscard]] BenchSummary summarizeClosings(const std::vector<nlohmann::json>& rows);
/// Of rows of benchPlanning(): a line a hand, and the objects that no hand holds, with the reasons.
[[nodiscard]] BenchSummary summarizePlans(const std::vector<nlohmann::json>& rows);
}  // namespace bullet_ccd::tools
