/// Where a soak run stands, kept in a small text file.
#pragma once

#include "benchmarks/soak/soak_subject.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
struct Checkpoint
{
    std::uint64_t firstSeed = 0;
    std::uint64_t nextSeed = 0;                ///< all before are done
    std::vector<SoakTally> tallies = {};       ///< one a family
    std::vector<std::uint64_t> failures = {};  ///< seeds
};

/// Replaces the file in one step, so that a run that is stopped leaves the old or the new one.
/// Throws std::runtime_error.
void save(const Checkpoint& checkpoint, const SoakSubject& subject, const std::string& path);

/// None if there is no such file. Throws std::runtime_error if it is that of another program,
/// cannot be understood, or its counts contradict each other.
[[nodiscard]] std::optional<Checkpoint> load(const SoakSubject& subject, const std::string& path);
}  // namespace bullet_ccd::tests
