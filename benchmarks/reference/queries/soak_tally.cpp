#include "benchmarks/reference/queries/soak_tally.h"

#include <algorithm>
#include <sstream>

namespace bullet_ccd::reference
{
const char* nameOf(ToiStatus status)
{
    constexpr std::array<const char*, 6> kNames{"separated",
                                                "hit",
                                                "overlapping",
                                                "touching_leaving",
                                                "touching_pressing",
                                                "iteration_limit"};
    return kNames[static_cast<std::size_t>(status)];
}

void SoakTally::add(ToiStatus status, Verdict verdict)
{
    ++queries;
    hits += status == ToiStatus::Hit || status == ToiStatus::TouchingPressing ? 1 : 0;
    overlapping += status == ToiStatus::Overlapping ? 1 : 0;
    free += status == ToiStatus::Separated || status == ToiStatus::TouchingLeaving ? 1 : 0;
    ++verdicts[static_cast<std::size_t>(verdict)];
}

void SoakTally::add(const SoakTally& other)
{
    queries += other.queries;
    hits += other.hits;
    overlapping += other.overlapping;
    free += other.free;
    for (std::size_t i = 0; i < verdicts.size(); ++i)
    {
        verdicts[i] += other.verdicts[i];
    }
}

std::int64_t SoakTally::wrong() const
{
    return queries - undecided() - verdicts[static_cast<std::size_t>(Verdict::Right)];
}

std::int64_t SoakTally::undecided() const
{
    return verdicts[static_cast<std::size_t>(Verdict::Undecided)];
}

std::string vacuity(std::span<const SoakTally> tallies,
                    std::span<const std::string> names,
                    const SoakShares& shares)
{
    std::ostringstream complaints;
    for (std::size_t i = 0; i < tallies.size(); ++i)
    {
        const SoakTally& tally = tallies[i];
        if (tally.queries < shares.enough)
        {
            continue;
        }
        const auto percent = [&](std::int64_t part) { return 100 * part / tally.queries; };
        if (percent(tally.hits) < shares.leastHits || percent(tally.free) < shares.leastFree ||
            percent(tally.overlapping) > shares.mostOverlapping)
        {
            complaints << names[i] << ": " << percent(tally.hits) << " % hits, "
                       << percent(tally.free) << " % free, " << percent(tally.overlapping)
                       << " % overlapping at the start\n";
        }
        if (1000 * tally.undecided() > tally.queries)
        {
            complaints << names[i] << ": " << tally.undecided() << " of " << tally.queries
                       << " undecided\n";
        }
    }
    return complaints.str();
}
}  // namespace bullet_ccd::reference
