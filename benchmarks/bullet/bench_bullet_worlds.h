/// Time per step of whole worlds.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// A pile of boxes, balls and hulls falls into a bin and is shot at; the worlds take turns step by
/// step.
/// @return one row per kind of world: "median" and "mean" of the steps [us], "outside" (bodies that
///         are out of the bin in the end), "queries" and "impacts" per step
[[nodiscard]] std::vector<nlohmann::json> runWorlds(int bodies, int steps);
}  // namespace bullet_ccd::benchmarks
