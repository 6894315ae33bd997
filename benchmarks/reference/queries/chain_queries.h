/// Random chains of two to ten joints among obstacles, one query for every seed; shared by the
/// tests and the soak program.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/queries/soak_tally.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
enum class ChainFamily : std::uint8_t
{
    Revolute,
    Prismatic,      ///< most joints slide
    Spherical,      ///< some joints turn about any axis
    Mixed,          ///< all kinds, fixed joints too, sometimes on a base that moves
    FloatingBase,   ///< the root flies and turns
    Mimic,          ///< joints that follow others
    SelfCollision,  ///< chains that curl up, no obstacles
    Fingers,        ///< planar chains that close on an obstacle
};
inline constexpr std::size_t kChainFamilies = 8;
inline constexpr int kFewestJoints = 2;
inline constexpr int kMostJoints = 10;
/// Seeds after which families and numbers of joints repeat.
inline constexpr std::uint64_t kChainRound = 72;

/// A quarter of the answers of each family is of either kind.
inline constexpr SoakShares kChainShares{.leastHits = 25, .leastFree = 25, .mostOverlapping = 25};

[[nodiscard]] const char* nameOf(ChainFamily family);
/// In the order of ChainFamily.
[[nodiscard]] std::vector<std::string> chainFamilyNames();

struct ChainQuery
{
    ChainFamily family = ChainFamily::Revolute;
    ArticulatedScene scene = {};
    ArticulatedToiOptions options = {};
};

/// The query of a seed: the family rotates with it, then the number of joints, then the way of
/// searching.
[[nodiscard]] ChainQuery chainQuery(std::uint64_t seed);

/// Joints, motions, meshes and options, digits enough to read them back.
void print(std::ostream& out, const ChainQuery& query);

struct ChainOutcome
{
    ArticulatedToiResult result = {};
    Judgement judgement = {};
};

/// Answers the query by the library and judges the answer.
[[nodiscard]] ChainOutcome runChainQuery(const ChainQuery& query);
}  // namespace bullet_ccd::reference
