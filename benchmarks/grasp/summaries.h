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
}  // namespace bullet_ccd::benchmarks
