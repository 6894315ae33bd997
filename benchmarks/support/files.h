/// Files that benchmarks read and write.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace bullet_ccd::benchmarks
{
/// The data folder: $BULLET_CCD_TEST_DATA, or ../shared/data beside the checkout.
[[nodiscard]] std::filesystem::path defaultDataFolder();

/// Writes a JSON file that says with which compiler and flags its program was built, too. Throws
/// std::runtime_error if it cannot be written.
void writeReport(const std::string& path, nlohmann::json report);
}  // namespace bullet_ccd::benchmarks
