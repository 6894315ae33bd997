/// Whether two features touch, without any rounding. Internal to the room.
///
/// Coordinates are doubles, so over a common power of two they are whole numbers, and corners of
/// the difference polygon are polynomials of degree 1 over them. A parallelogram is two triangles.
/// The origin is in a moving triangle only at roots of the determinant of its corners (degree 3).
/// At a root, or where that vanishes all the time at a root of what replaces it, signs of
/// polynomials say whether the origin is inside. Signs at a root are found by Sturm's and Tarski's
/// theorem, from whole numbers alone. Takes ten to a hundred microseconds, so it is asked last;
/// with a distance tens of milliseconds, unless coordinates have few digits.
///
/// With a distance the moments are those when a corner, the line of an edge or the plane of the
/// face is exactly that far away (polynomials of degree 2, 4 and 6), and the nearest point is
/// within.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"

namespace bullet_ccd
{
/// True if and only if two points of the features are at most `distance` apart at some time in
/// [0, 1]; without a distance, if the features have a point in common.
/// @pre all coordinates are finite, the distance is, too, and not negative
[[nodiscard]] bool featuresTouch(const ElementaryPair& pair, double distance = 0.0);
}  // namespace bullet_ccd
