/// The scene of the human by other methods: every pair of a link and an obstacle on its own.
#pragma once

#include "benchmarks/articulated/human_scene.h"
#include "benchmarks/peers/fcl_peer.h"

#include <utility>
#include <vector>

namespace bullet_ccd::benchmarks
{
inline constexpr double kHumanTolerance = 1e-5;  ///< of all methods [m]
/// The query, whole or with a stage of it switched off.
struct Stage
{
    const char* name;
    ArticulatedToiOptions options;
};

/// The whole query first.
[[nodiscard]] std::vector<Stage> humanStages();

inline constexpr double kNever = 2.0;  ///< time of no contact

/// Earliest contact of all pairs by rigidToi(), one by one, without culling; kNever for
/// none.
[[nodiscard]] double rigidTime(const HumanScene& scene,
                               const HumanQuery& query,
                               double tolerance,
                               ToiWorkspace& work);

/// The links and obstacles as FCL has them.
class FclHuman
{
public:
    explicit FclHuman(const HumanScene& scene);

    /// Earliest of `samples` times, 0 and 1 among them, at which a link intersects an obstacle;
    /// kNever for none. Pairs that intersect at the start are left out. All links are placed where
    /// they are at each time; every pair is tested.
    [[nodiscard]] double firstSample(const HumanQuery& query, int samples) const;

    /// Whether a link intersects an obstacle at time t; pairs that do at the start are left out.
    [[nodiscard]] bool overlaps(const HumanQuery& query, double t) const;

    /// Distance of a link and an obstacle at time t.
    [[nodiscard]] double distanceOf(const HumanQuery& query,
                                    std::int32_t link,
                                    std::int32_t obstacle,
                                    double t) const;

private:
    using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

    [[nodiscard]] Pairs pairsOf(const HumanQuery& query) const;
    [[nodiscard]] bool overlap(const HumanQuery& query, const Pairs& pairs, double t) const;

    const HumanScene& m_scene;
    std::vector<FclModel> m_links;
    std::vector<FclModel> m_pieces;
    std::vector<const FclModel*> m_obstacles;
};
}  // namespace bullet_ccd::benchmarks
