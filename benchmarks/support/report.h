/// JSON files that say how their program was built.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace bullet_ccd::benchmarks
{
/// Adds the compiler and its flags, and writes the file. Throws std::runtime_error if it cannot be
/// written.
void writeReport(const std::string& path, nlohmann::json report);
}  // namespace bullet_ccd::benchmarks
