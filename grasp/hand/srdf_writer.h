/// What is known of a hand as the SRDF that says it.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/hand/hand_model.h"

#include <string>

namespace bullet_ccd::grasp
{
/// An SRDF with a comment at every kind of element: fingers, preshapes, joints that do not close,
/// closing directions and grasp frames. Disabled pairs are left out; `grasp hand check` finds them.
///
/// Guarantee: loadHand() understands the hand by it as it is here, up to the digits written (1e-6
/// of positions and frames), but for the pairs of links that are tested against each other.
[[nodiscard]] BULLET_CCD_API std::string handSrdf(const HandModel& hand);
}  // namespace bullet_ccd::grasp
