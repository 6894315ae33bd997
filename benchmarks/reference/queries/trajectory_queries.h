/// Random trajectories of the chains of chain_queries.h, one query for every seed: the first
/// contact judged by brute force segment by segment, the least distance by brute-force distances.
#pragma once

#include "benchmarks/reference/queries/chain_queries.h"
#include "bullet_ccd/trajectory/trajectory.h"

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
enum class TrajectoryKind : std::uint8_t
{
    Linear,
    Cubic,    ///< Hermite, through velocities
    Quintic,  ///< through velocities and accelerations
    Spline,   ///< B-splines of degrees 1 to 5
};
inline constexpr std::size_t kTrajectoryKinds = 4;
/// Seeds after which kinds, families and numbers of joints repeat.
inline constexpr std::uint64_t kTrajectoryRound = 5 * 9 * kTrajectoryKinds;

/// In the order of TrajectoryKind.
[[nodiscard]] std::vector<std::string> trajectoryKindNames();

/// Roots, obstacles and spherical joints rest.
struct TrajectoryQuery
{
    TrajectoryKind family = TrajectoryKind::Linear;
    ChainQuery chain = {};
    Trajectory trajectory = {};
    LeastDistanceOptions least = {};
};

/// The query of a seed: the kind rotates with it, then the family, then the number of joints.
[[nodiscard]] TrajectoryQuery trajectoryQuery(std::uint64_t seed);

void print(std::ostream& out, const TrajectoryQuery& query);

struct TrajectoryOutcome
{
    TrajectoryToiResult result = {};
    TrajectoryLeastDistance least = {};
    Judgement judgement = {};
};

/// The first complaint about the two answers. A least distance above one that brute force finds is
/// Late; one that is more than its tolerance below what was found, or was not found, WrongGap.
[[nodiscard]] Judgement judgeTrajectory(const TrajectoryQuery& query,
                                        const TrajectoryToiResult& result,
                                        const TrajectoryLeastDistance& least);

/// Answers by the library and judges the answers.
[[nodiscard]] TrajectoryOutcome runTrajectoryQuery(const TrajectoryQuery& query);
}  // namespace bullet_ccd::reference
