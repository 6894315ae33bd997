/// The approach: the hand moves without closing until its first contact.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/hand/hand_model.h"

#include <vector>

namespace bullet_ccd::grasp
{
/// First contact of any link with the environment while the hand, joints at rest at `positions`,
/// moves along `shift` (W) from X_WH. A hit leaves about half the tolerance, so that closing can go
/// on from there. See articulatedToi() for the guarantee and what it throws.
[[nodiscard]] ArticulatedToiResult approachUntilContact(const HandModel& hand,
                                                        const Environment& environment,
                                                        const Eigen::Isometry3d& X_WH,
                                                        const std::vector<double>& positions,
                                                        const Eigen::Vector3d& shift,
                                                        double tolerance,
                                                        ToiWorkspace& work);
}  // namespace bullet_ccd::grasp
