/// A range of soak queries over several threads.
#pragma once

#include "benchmarks/soak/checkpoint.h"

#include <cstdint>
#include <string>

namespace bullet_ccd::tests
{
struct SoakRun
{
    std::uint64_t firstSeed = 1;
    std::uint64_t count = 1;
    int jobs = 1;
    bool resume = false;
    std::string checkpointPath = {};
};

/// Runs the queries, prints progress and failures to standard output. The tallies do not depend on
/// the number of threads. A run that is killed has kept all but the rounds in hand. Throws
/// std::runtime_error for a checkpoint that does not fit or cannot be written.
[[nodiscard]] Checkpoint runSoak(const SoakSubject& subject, const SoakRun& run);
}  // namespace bullet_ccd::tests
