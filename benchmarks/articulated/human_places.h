/// Where the 16 chessmen stand in the scenes of the human.
#pragma once

#include <array>
#include <cstddef>

namespace bullet_ccd::benchmarks
{
inline constexpr std::array<const char*, 6> kChessmen{
    "king", "queen", "bishop", "knight", "rook", "pawn"};

/// On the board, in the recording's frame.
struct Place
{
    std::size_t man;  ///< index into kChessmen
    double x;         ///< [m]
    double z;         ///< [m]
};

using Places = std::array<Place, 16>;

/// Found by trying positions 5 cm apart: first those at which a link enters a man between two
/// frames and is through it soon, then those that are passed closely without being touched.
inline constexpr Places kWalkPlaces{{{2, 1.25, -0.10},
                                     {5, 0.85, 0.30},
                                     {0, -0.10, 0.50},
                                     {1, 0.40, 0.55},
                                     {2, 0.30, -0.30},
                                     {5, -0.35, -0.20},
                                     {5, 0.80, -0.30},
                                     {5, 1.50, 0.30},
                                     {4, -0.45, 0.15},
                                     {5, 1.65, -0.05},
                                     {5, -0.05, -0.40},
                                     {5, 1.10, -0.45},
                                     {5, 1.20, 0.45},
                                     {3, 1.55, -0.40},
                                     {4, 0.60, -0.60},
                                     {3, -0.45, -0.55}}};

inline constexpr Places kRunPlaces{{{3, 2.70, -0.10},
                                    {3, 1.50, -0.30},
                                    {4, 0.60, -0.25},
                                    {2, 0.25, 0.30},
                                    {2, 0.75, 0.30},
                                    {1, 3.05, 0.30},
                                    {0, 1.40, 0.35},
                                    {4, 0.20, -0.30},
                                    {5, 2.15, -0.10},
                                    {5, 3.10, -0.10},
                                    {5, 2.45, 0.30},
                                    {5, -0.20, -0.30},
                                    {5, 2.35, -0.35},
                                    {5, 1.95, 0.35},
                                    {5, -0.35, 0.15},
                                    {5, 1.05, -0.35}}};

inline constexpr Places kKickPlaces{{{2, 0.85, -1.05},
                                     {0, 0.50, 0.40},
                                     {1, 1.35, 0.10},
                                     {2, 1.00, -0.25},
                                     {4, 1.45, -0.70},
                                     {3, 0.90, 0.20},
                                     {4, 0.55, -0.65},
                                     {5, -0.25, 0.20},
                                     {5, 0.10, -0.10},
                                     {5, 1.35, -0.35},
                                     {3, 1.25, -1.15},
                                     {5, 0.25, -0.45},
                                     {5, -0.25, -0.15},
                                     {5, 0.05, 0.35},
                                     {5, -0.10, -0.45},
                                     {5, -0.20, 0.55}}};
}  // namespace bullet_ccd::benchmarks
