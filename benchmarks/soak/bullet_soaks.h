/// Bullet worlds as subjects of a soak; the exact check of benchmarks/reference/audit looks at
/// rigid ones.
#pragma once

#include "benchmarks/reference/audit/world_audit.h"
#include "benchmarks/soak/soak.h"
#include "bullet_ccd/examples/example_support.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

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

struct SoftSoak
{
    double seconds = 0.5;    ///< simulated time of a drop [s]
    bool withStock = false;  ///< every drop in stock Bullet, too
};

/// Random drops of cloth, ropes and volumes in Bullet's deformable worlds, looked at in every step
/// by a judge that shares nothing with the library. Wrong if a node went through anything, an edge
/// crosses a face at the end, or a node is not finite.
[[nodiscard]] SoakSubject softSoak(const SoftSoak& soak);

// What the soaks under the exact check share.

/// A shape, and what is to be known of it.
struct HouseholdObject
{
    std::string name;
    std::shared_ptr<const reference::AuditMesh> audit;
    std::shared_ptr<const SsvTree> tree;
    double mass = 0.0;   ///< [kg]
    double reach = 0.0;  ///< from the centre of mass, the origin [m]
};

/// Number 0 and on: all families in turn, first in their usual sizes, then in sizes by the seed.
[[nodiscard]] HouseholdObject makeHouseholdObject(std::size_t number,
                                                  std::uint64_t seed,
                                                  double density);

[[nodiscard]] std::map<std::string, std::int64_t> countsOf(const btCcdControl& control,
                                                           const reference::AuditResult& seen);

/// Prints a line on a world, the busiest of its pairs, and the counts.
void printWorld(const std::string& what,
                const reference::WorldAudit::Busiest& busiest,
                const std::vector<std::string>& names,
                const std::map<std::string, std::int64_t>& counts);

/// Nothing may intersect, and nothing else be wrong.
[[nodiscard]] reference::Judgement judgementOf(const reference::AuditResult& seen,
                                               const std::vector<std::string>& names,
                                               const std::string& otherwise);
}  // namespace bullet_ccd::benchmarks
