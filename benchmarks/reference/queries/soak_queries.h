/// Random and adversarial rigid queries on small meshes, one for every seed; shared by the tests
/// and the soak program.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/rigid_scene.h"
#include "bullet_ccd/toi/toi.h"

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
enum class SoakFamily : std::uint8_t
{
    Soups,          ///< random triangles that fly at each other, some start overlapping
    Slivers,        ///< aspect ratios up to 1e9
    Degenerate,     ///< triangles that are segments or points
    CoplanarFaces,  ///< axis-aligned boxes whose faces lie in common planes
    ParallelEdges,  ///< bars whose edges are parallel, exactly or almost
    ThinPlates,     ///< plates that cross in 1/100 to 1/1000 of the motion
    Spikes,         ///< needles and cones, tip to tip
    Grazing,        ///< an obstacle at the extreme of the motion, less or more than a small gap
    NearMiss,       ///< edges that pass at a small gap
    MultiTurn,      ///< up to ten turns
    BothTurning,    ///< each about an axis of its own, one or both about a point off the body
    CoMoving,       ///< common velocity and rotation with a small difference
    FarSmall,       ///< parts of 1e-3 at places of 1e3
    Scales,         ///< lengths of 1e-9 to 1e9
    StartTouching,  ///< the motion begins within the tolerance
    Clearance,      ///< queries with a minimum separation
};
inline constexpr std::size_t kSoakFamilies = 16;

[[nodiscard]] const char* nameOf(SoakFamily family);
/// In the order of SoakFamily.
[[nodiscard]] std::vector<std::string> soakFamilyNames();
[[nodiscard]] const char* nameOf(ToiStrategy strategy);

struct SoakQuery
{
    SoakFamily family = SoakFamily::Soups;
    RigidScene scene = {};
    ToiOptions options = {};
};

/// The query of a seed: the family rotates with it, then the strategy.
[[nodiscard]] SoakQuery soakQuery(std::uint64_t seed);

/// Meshes, motions and options, digits enough to read them back.
void print(std::ostream& out, const SoakQuery& query);

struct SoakOutcome
{
    ToiResult result = {};
    Judgement judgement = {};
};

/// Answers the query by the library and judges the answer.
[[nodiscard]] SoakOutcome runSoakQuery(const SoakQuery& query);
}  // namespace bullet_ccd::reference
