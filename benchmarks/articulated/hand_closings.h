/// Hands that close around household objects, from open to the limits of their joints in one query.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct ClosingOptions
{
    std::filesystem::path data;
    std::filesystem::path share;  ///< holds robots/srdf/
    std::vector<std::string> hands{"schunk_sah", "allegro", "shadow", "schunk_svh", "leap"};
    int configurations = 100;  ///< of each hand
    int repeats = 5;
    std::uint64_t seed = 1;
};

/// Prints a row a hand. Returns whether all answers are right. Throws std::runtime_error for files
/// that are missing and for hands that are not known.
[[nodiscard]] bool runHandClosings(const ClosingOptions& options);
}  // namespace bullet_ccd::benchmarks
