/// A range of soak queries over several threads.
#pragma once

#include "tools/soak/checkpoint.h"

#include <cstdint>
#include <string>

namespace bullet_ccd::tests
{
struct SoakRun
{
    std::uint64_t firstSeed = 1;
    std::uint64_t count = 1'000'000;
    int jobs = 1;
    bool resume = false;
    std::string checkpointPath = {};  ///< empty: none is kept
};

/// Runs the queries, prints progress and failures to standard output. The tallies do not depend on
/// the number of threads. Throws std::runtime_error for a checkpoint that does not fit.
[[nodiscard]] Checkpoint runSoak(const SoakRun& run);
}  // namespace bullet_ccd::tests
