/// Small hands made of boxes, and objects to grasp.
#pragma once

#include "grasp/hand/hand_model.h"

namespace bullet_ccd::tests
{
/// Two jaws that slide along x; opening 80 mm. `coupled`: the right jaw mimics the left one.
[[nodiscard]] grasp::HandModel makeGripper(bool coupled);

/// Three fingers of two links each around z, 120 degrees apart, that curl inwards.
[[nodiscard]] grasp::HandModel makeThreeFingers();
}  // namespace bullet_ccd::tests
