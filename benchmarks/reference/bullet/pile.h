/// A pile of boxes, balls and meshes that keep hitting each other, and what flies beside it.
#pragma once

#include "benchmarks/reference/bullet/scene.h"

#include <cstdint>

namespace bullet_ccd::reference
{
/// Side of the cube that a body of the pile has for itself in the beginning [m].
inline constexpr double kPileSpacing = 0.064;

struct PileOptions
{
    bool meshes = true;  ///< a quarter of the bodies; else boxes, balls and hulls only
    double wallHeight = 0.2;
};

/// Drops `count` bodies of mixed shapes and some 4 cm in size into a bin of that half width about
/// the origin; gravity along -z.
void addPile(
    Scene& scene, int count, double binHalf, std::uint64_t seed, const PileOptions& options = {});

struct PileFall
{
    double way = 0.0;       ///< that a body beside the pile fell in 1 s [m]
    double expected = 0.0;  ///< g t^2 / 2
    std::int64_t impacts = 0;
};
[[nodiscard]] PileFall fallBesidePile(Kind kind);
}  // namespace bullet_ccd::reference
