/// Of grasps that are force closures, those that carry: closed where only fingers touch, and ranked
/// by the weight that they hold as hard as they squeeze.
#pragma once

#include "grasp/task/pick_place.h"

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// The largest mass that the grasp holds whichever way its weight pulls (largestMassHeld()), with
/// the torques of its squeeze (squeezeOf()) and a tenth of the efforts, which a controller adds
/// when it is pushed off by that share of its range [kg]. 0 if the contacts cannot be squeezed.
[[nodiscard]] double massHeldBySqueeze(const HandModel& hand,
                                       const GraspObject& object,
                                       const Grasp& grasp,
                                       const PickPlaceOptions& options);

/// The grasps that are left, those that hold most first. The hand is drawn back against its
/// direction of approach until, open, it is `margin` away from the object, and closes there anew;
/// neither open nor closed does it come within the margin of an obstacle. What it holds is
/// quality.largestMass, and is at least options.holds times the mass (options.grasps.mass).
/// @param grasps     of the object, whose frame is W
/// @param obstacles  in the same frame
[[nodiscard]] std::vector<Grasp> firmGrasps(const HandModel& hand,
                                            const GraspObject& object,
                                            std::span<const RigidBody> obstacles,
                                            const std::vector<Grasp>& grasps,
                                            const PickPlaceOptions& options);

/// True if no link of the hand is nearer to a body than `margin`.
[[nodiscard]] bool isClear(const HandModel& hand,
                           const Eigen::Isometry3d& X_WH,
                           const std::vector<double>& positions,
                           std::span<const RigidBody> bodies,
                           double margin);
}  // namespace bullet_ccd::grasp
