/// What a soak counts: answers of each family of queries by status and verdict.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"
#include "bullet_ccd/toi/toi.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
[[nodiscard]] const char* nameOf(ToiStatus status);

/// Counts of one family.
struct SoakTally
{
    std::int64_t queries = 0;
    std::int64_t hits = 0;  ///< contact after the start
    std::int64_t overlapping = 0;
    std::int64_t free = 0;
    std::array<std::int64_t, 8> verdicts = {};  ///< by Verdict

    void add(ToiStatus status, Verdict verdict);
    void add(const SoakTally& other);
    [[nodiscard]] std::int64_t wrong() const;  ///< neither right nor undecided
    [[nodiscard]] std::int64_t undecided() const;

    bool operator==(const SoakTally& other) const = default;
};

/// Shares of all queries of a family that let its answers prove something [%].
struct SoakShares
{
    std::int64_t leastHits = 10;
    std::int64_t leastFree = 5;
    std::int64_t mostOverlapping = 50;
    std::int64_t enough = 200;  ///< queries of a family without which there is nothing to say
};

/// Complaints about tallies that prove little: a family that nearly always or never hits, too many
/// undecided. Families with fewer than `shares.enough` queries are not looked at. Empty if all is
/// well.
/// @param names of the families, as many as tallies
[[nodiscard]] std::string vacuity(std::span<const SoakTally> tallies,
                                  std::span<const std::string> names,
                                  const SoakShares& shares);
}  // namespace bullet_ccd::reference
