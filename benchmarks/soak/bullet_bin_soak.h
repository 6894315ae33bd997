/// Household objects in a bin for a long time.
#pragma once

#include <cstdint>

namespace bullet_ccd::tests
{
struct BinSoak
{
    int objects = 200;
    double seconds = 20.0;
    double timeStep = 1.0 / 240.0;  ///< [s]
    std::uint64_t seed = 1;
    double longestMove = 5e-3;  ///< between two poses that are looked at [m]
    int mostSamples = 8;        ///< in a step
    double restSpeed = 0.05;    ///< largest mean speed at the end [m/s]; negative: no matter
};

/// Prints what happens; false if anything intersects, has left the bin, or is not at rest.
[[nodiscard]] bool runBinSoak(const BinSoak& soak);
}  // namespace bullet_ccd::tests
