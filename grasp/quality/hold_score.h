/// How likely a grasp is to hold, by what is known without a simulation.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

namespace bullet_ccd::grasp
{
/// The chance [0, 1] that the trial `six` (protocol.h) holds, by a logistic function of
///     1,
///     ln(min(4, GraspQuality::largestMass / mass + 0.1)), and
///     epsilon,
/// so what can hold its object four times is as good as what can hold it more often, and epsilon
/// decides: the efforts then suffice, and what is left is where the contacts are. With coefficients
/// (hold_score_coefficients.h) that tools/fit_score found from trials of one half of the objects
/// and checked on the other. 0 for what is no force closure. Meant for ranking: the chance is that
/// of the hands, objects and masses of the fit.
/// @param mass  of the object [kg], above 0
[[nodiscard]] BULLET_CCD_API double holdScore(const Grasp& grasp, double mass);
}  // namespace bullet_ccd::grasp
