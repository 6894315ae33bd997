/// A closing engine for tests: the contract of CloseHand by articulatedToi alone, without Bullet.
#pragma once

#include "grasp/closing/closing.h"

namespace bullet_ccd::tests
{
/// Closes in time [0, 1] at constant rates from the preshape to the closed positions. A link that
/// touches stops for good, with every joint between it and the root and the joints coupled to
/// those.
[[nodiscard]] grasp::ClosingResult closeByToi(const grasp::HandModel& hand,
                                              const grasp::GraspObject& object,
                                              const Eigen::Isometry3d& X_WH,
                                              const std::vector<double>& positions,
                                              const grasp::ClosingOptions& options);
}  // namespace bullet_ccd::tests
