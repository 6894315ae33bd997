/// Bullet worlds as subjects of a soak; the exact check of benchmarks/reference/audit looks at
/// rigid ones.
#pragma once

#include "benchmarks/soak/soak.h"

struct btCcdCounters;

namespace bullet_ccd::benchmarks
{
/// What a world of ours has counted.
[[nodiscard]] std::map<std::string, std::int64_t> namedCounts(const btCcdCounters& counters);

struct BinSoak
{
    int objects = 200;
    double seconds = 20.0;
    double timeStep = 1.0 / 240.0;  ///< [s]
    double longestMove = 5e-3;      ///< between two poses that are looked at [m]
    int mostSamples = 8;            ///< in a step
    double restSpeed = 0.05;        ///< largest mean speed at the end [m/s]
    double accuracy = 0.0;          ///< of models in place of the meshes [m]; 0: full meshes
};

/// Household objects in a bin for a long time, a world for each seed, which chooses places and
/// sizes. Wrong if anything intersects (of models: full meshes by the accuracy), has left the bin,
/// or is not at rest.
[[nodiscard]] SoakSubject binSoak(const BinSoak& soak);

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

struct SoftSoak
{
    double seconds = 0.5;    ///< simulated time of a drop [s]
    bool withStock = false;  ///< every drop in stock Bullet, too
};

/// Random drops of cloth, ropes and volumes in Bullet's deformable worlds, looked at in every step
/// by a judge that shares nothing with the library. Wrong if a node went through anything, an edge
/// crosses a face at the end, or a node is not finite.
[[nodiscard]] SoakSubject softSoak(const SoftSoak& soak);
}  // namespace bullet_ccd::benchmarks
