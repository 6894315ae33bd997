/// Bullet worlds under the exact check of benchmarks/reference/audit, as subjects of a soak.
#pragma once

#include "benchmarks/soak/soak.h"

#include <cstdint>
#include <filesystem>

namespace bullet_ccd::benchmarks
{
struct BinSoak
{
    int objects = 200;
    double seconds = 20.0;
    double timeStep = 1.0 / 240.0;  ///< [s]
    double longestMove = 5e-3;      ///< between two poses that are looked at [m]
    int mostSamples = 8;            ///< in a step
    double restSpeed = 0.05;        ///< largest mean speed at the end [m/s]
};

/// Household objects in a bin for a long time, a world for each seed, which chooses places and
/// sizes. Wrong if anything intersects, has left the bin, or is not at rest.
[[nodiscard]] SoakSubject binSoak(const BinSoak& soak);

struct HandSoak
{
    std::filesystem::path hand;     ///< URDF
    int closings = 20;              ///< of the hand on each object
    double timeStep = 1.0 / 240.0;  ///< [s]
    double longestMove = 2e-3;      ///< between two poses that are looked at [m]
    int mostSamples = 4;            ///< in a step
};

/// A hand that closes on an object and opens again, many times; an object for each seed: all
/// families in turn, first in their usual sizes. Wrong if anything intersects: links with the
/// object, or links that can meet with each other. A hit is an object that the hand holds in at
/// least half of its closings.
[[nodiscard]] SoakSubject handSoak(const HandSoak& soak);

struct RandomSoak
{
    int bodies = 45;       ///< in most worlds at most so many begin, in every fourth three times
    double seconds = 5.0;  ///< simulated time [s]
};

/// Closed rooms of thin and thick walls with bodies of all shapes, joints, motors, kinematic
/// objects, bodies that come, go, are put elsewhere or get other shapes, in worlds of all classes
/// and by action. Wrong if a body that was not squeezed gets past the middle of a wall, if a pose
/// or a velocity is not finite, or if a step does not end.
[[nodiscard]] SoakSubject randomSoak(const RandomSoak& soak);
}  // namespace bullet_ccd::benchmarks
