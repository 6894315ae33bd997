/// A hand that closes on objects and opens again, many times.
#pragma once

#include <cstdint>
#include <filesystem>

namespace bullet_ccd::tests
{
struct HandSoak
{
    std::filesystem::path hand;  ///< URDF
    int objects = 30;
    int closings = 20;              ///< of the hand on each object
    double timeStep = 1.0 / 240.0;  ///< [s]
    std::uint64_t seed = 1;         ///< of the objects' sizes and poses
    double longestMove = 2e-3;      ///< between two poses that are looked at [m]
    int mostSamples = 4;            ///< in a step
};

/// Prints what happens; false if the hand never touches an object, or anything intersects: links
/// with the object, or links that can meet with each other.
[[nodiscard]] bool runHandSoak(const HandSoak& soak);
}  // namespace bullet_ccd::tests
