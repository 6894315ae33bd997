/// Whether two features touch, where double precision can prove it. Internal to the room.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"

namespace bullet_ccd
{
/// True only if featuresTouch() is. It looks about the time only, which a search in double
/// precision has found, and takes a fraction of a microsecond; so it is asked first.
///
/// Without a distance: the determinant of the corners of the difference polygon changes its sign
/// between two times, and all that time the projection of the origin is inside; or everything stays
/// in one plane across an axis, and the origin is inside at one time. With a distance: a point of
/// the polygon is nearer at one time. All signs and distances are beyond their rounding.
/// @pre all coordinates are finite
[[nodiscard]] bool certainlyTouch(const ElementaryPair& pair, double distance, double time);
}  // namespace bullet_ccd
