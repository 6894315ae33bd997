/// Tables of what was judged, and whether it is good.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Prints a line per hand of rows of judgeClosings(), and the closings that nothing explains.
/// @return whether all is good
[[nodiscard]] bool summarizeClosings(const std::vector<nlohmann::json>& rows);
/// Prints a line per hand of rows of judgePlans(), and the objects that no hand holds, with the
/// reasons.
/// @return whether any object is held
[[nodiscard]] bool summarizePlans(const std::vector<nlohmann::json>& rows);

/// What follows the name of a hand in rows of judgePlans() that did not see its SRDF.
inline constexpr const char* kWithoutSrdf = ", inferred";
/// Prints a line per hand that has rows with and without its SRDF: both rates, and their ratio with
/// an interval of 95 %, by drawing the objects anew 2,000 times.
/// @return whether each rate without is at least 0.9 of that with, and each rate with at least 0.97
///         of that without
[[nodiscard]] bool summarizeInference(const std::vector<nlohmann::json>& rows);
}  // namespace bullet_ccd::benchmarks
