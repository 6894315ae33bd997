/// Whether two features touch, without any rounding. Internal to the room.
///
/// Coordinates are doubles, so over a common power of two they are whole numbers, and corners of
/// the difference polygon are polynomials of degree 1 over them. A parallelogram is two triangles.
/// The origin is in a moving triangle only at roots of the determinant of its corners (degree 3).
/// At a root, or where that vanishes all the time at a root of what replaces it, signs of
/// polynomials say whether the origin is inside. Signs at a root are found by Sturm's and Tarski's
/// theorem, from whole numbers alone. Takes tens of microseconds, so it is asked last.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"

namespace bullet_ccd
{
/// True if and only if the features have a point in common at some time in [0, 1].
/// @pre all coordinates are finite
[[nodiscard]] bool featuresTouch(const ElementaryPair& pair);
}  // namespace bullet_ccd
