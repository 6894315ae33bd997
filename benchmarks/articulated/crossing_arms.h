/// Two arms with hands that cross each other.
#pragma once

#include <cstdint>
#include <filesystem>

namespace bullet_ccd::benchmarks
{
struct ArmsOptions
{
    std::filesystem::path data;
    int configurations = 100;
    int repeats = 5;
    std::uint64_t seed = 1;
};

/// Prints a row. Returns whether all answers are right. Throws std::runtime_error for files that
/// are missing.
[[nodiscard]] bool runCrossingArms(const ArmsOptions& options);
}  // namespace bullet_ccd::benchmarks
