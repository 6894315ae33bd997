/// Whether two triangles meet, decided exactly.
///
/// Corners are rounded once to a grid of 2^-36 m (15 picometres); on the grid every determinant is
/// an integer of fewer than 127 bits, so no answer depends on rounding. Meshes that share corners
/// stay closed. Triangles are closed sets: touching is meeting.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace bullet_ccd::reference
{
using GridPoint = std::array<std::int64_t, 3>;
using GridTriangle = std::array<GridPoint, 3>;

inline constexpr double kGridsPerMetre = 68719476736.0;  // 2^36
inline constexpr double kGridReach = 16.0;               ///< largest coordinate [m]

/// Throws std::invalid_argument for a coordinate beyond kGridReach (or NaN).
[[nodiscard]] GridPoint toGrid(const Eigen::Vector3d& point);

/// Sign of the volume of the tetrahedron a, b, c, d: positive if d sees a, b, c clockwise, that is
/// if d lies on the side that (b - a) x (c - a) points to.
[[nodiscard]] int sideOf(const GridPoint& a,
                         const GridPoint& b,
                         const GridPoint& c,
                         const GridPoint& d);

/// A triangle that is degenerate on the grid meets by its edges only.
[[nodiscard]] bool trianglesMeet(const GridTriangle& a, const GridTriangle& b);
}  // namespace bullet_ccd::reference
