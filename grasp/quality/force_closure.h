/// Force closure of a finite set of wrenches, by one linear program.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

#include <span>

namespace bullet_ccd::grasp
{
/// True if the origin lies inside the convex hull of the wrenches, not on its boundary: they span
/// all six dimensions, and some combination of all of them with positive weights is 0. Does not
/// depend on the point that moments are about. Much faster than the hull; says nothing about how
/// far inside. With wrenches of inscribed pyramids "true" holds for the cones as well.
[[nodiscard]] BULLET_CCD_API bool isForceClosure(std::span<const Wrench> wrenches);
}  // namespace bullet_ccd::grasp
