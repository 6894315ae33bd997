/// How likely a grasp is to hold, by what is known without a simulation.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/squeeze/squeeze.h"

namespace bullet_ccd::grasp
{
/// The chance [0, 1] that the trial `six` (protocol.h) holds, by a logistic function of
///     1, sqrt(epsilon), ln(Squeeze::weights + 0.1), and the number of links that touch,
/// with coefficients (hold_score_coefficients.h) that tools/fit_score found from trials of one half
/// of the objects and checked on the other. 0 without a squeeze. Meant for ranking: the chance is
/// that of the hands, objects and masses of the fit.
[[nodiscard]] BULLET_CCD_API double holdScore(const Grasp& grasp, const Squeeze& squeeze);
}  // namespace bullet_ccd::grasp
