/// Where a long run stands, kept in a file: a run that was stopped goes on from there.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace bullet_ccd::benchmarks
{
/// Replaces the file in one step, so that a run that is killed leaves the old or the new one.
/// @param run  what the state belongs to: program and settings
/// Throws std::runtime_error.
void saveCheckpoint(const std::string& path,
                    const nlohmann::json& run,
                    const nlohmann::json& state);

/// None if there is no such file. Throws std::runtime_error if the file is damaged or belongs to
/// another run.
[[nodiscard]] std::optional<nlohmann::json> loadCheckpoint(const std::string& path,
                                                           const nlohmann::json& run);
}  // namespace bullet_ccd::benchmarks
