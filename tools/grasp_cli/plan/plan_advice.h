/// What to look at when a plan holds little.
#pragma once

#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <span>
#include <string>

namespace bullet_ccd::tools
{
/// How many force closures are firm (epsilon from 0.2), fair (from 0.05) and marginal (below).
[[nodiscard]] std::string epsilonClasses(std::span<const grasp::Grasp> grasps);

/// One line for the reason that rejected most candidates, if fewer than a tenth of all are force
/// closures; else empty.
/// @param hasTable  one under the object was in the hand's way
[[nodiscard]] std::string planAdvice(const grasp::HandModel& hand,
                                     const grasp::GraspObject& object,
                                     std::span<const grasp::Grasp> grasps,
                                     bool hasTable);
}  // namespace bullet_ccd::tools
