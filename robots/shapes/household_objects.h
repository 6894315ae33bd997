/// Household objects by formula: families with random sizes, in metres, z up, resting on z = 0 and
/// centred in x and y. Every object is one closed two-manifold surface.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::shapes
{
/// Names of all families, in the order in which make_objects takes turns.
[[nodiscard]] const std::vector<std::string>& objectFamilies();

/// An object of the family: the usual sizes without a seed, else sizes drawn from it. A pure
/// function of its arguments. Throws std::invalid_argument for an unknown family (the message lists
/// the known ones) and a coarseness below 1.
/// @param coarseness  edges may be so many times as long as usual; the number of triangles falls by
///                    up to the square of it, least where walls are thin
[[nodiscard]] TriangleMesh makeObject(const std::string& family,
                                      std::optional<std::uint64_t> seed = std::nullopt,
                                      double coarseness = 1.0);
}  // namespace bullet_ccd::shapes
