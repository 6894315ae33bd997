/// Hands that close around household objects, from open to the limits of their joints in one query.
#pragma once

#include "benchmarks/articulated/linkage_run.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct ClosingOptions
{
    LinkageOptions linkage;
    std::filesystem::path share;  ///< holds robots/srdf/
    std::vector<std::string> hands{"schunk_sah", "allegro", "shadow", "schunk_svh", "leap"};
};

/// Prints one row per hand. Returns whether all answers are right. Throws std::runtime_error for
/// files that are missing and for hands that are not known.
[[nodiscard]] bool runHandClosings(const ClosingOptions& options);
}  // namespace bullet_ccd::benchmarks
