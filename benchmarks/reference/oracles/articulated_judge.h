/// Judges an answer of articulatedToi by brute force over all pairs of triangles.
///
/// Every pair of bodies that was asked about marches up to the reported time, see bruteForceToi():
/// a crossing there makes the answer late, or missed where it says that there is none. At the
/// reported time all distances are compared with the contacts that the answer names and with those
/// that it does not name.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "bullet_ccd/toi/articulated_toi.h"

namespace bullet_ccd::reference
{
/// What rounding may do to a distance in that scene: 512 units in the last place of the sum of all
/// that a link can reach and the farthest that an obstacle lies.
[[nodiscard]] double distanceRounding(const ArticulatedScene& scene);

/// The least distance of the pairs that move relative to each other, or of the named one, at some
/// times in [0, 1].
[[nodiscard]] double leastDistanceAt(const ArticulatedScene& scene,
                                     std::span<const double> times,
                                     const LinkContact* named = nullptr);

/// The first complaint, or Verdict::Right. Missed are also pairs of links and obstacles that come
/// within the tolerance at the reported time and are not among the contacts.
/// @pre no minimum separation, no masks
[[nodiscard]] Judgement judgeArticulated(const ArticulatedScene& scene,
                                         const ToiOptions& options,
                                         const ArticulatedToiResult& result);
}  // namespace bullet_ccd::reference
