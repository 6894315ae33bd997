/// Of grasps that are force closures, those that carry: closed where only fingers touch, and ranked
/// by the weight that they hold as hard as they squeeze.
#pragma once

#include "grasp/task/pick_place.h"

#include <functional>
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

/// Whether the arm brings the open hand to a grasp along its approach; is asked from any thread.
using ArrivesAt = std::function<bool(const Grasp& grasp)>;

/// The grasps that are left, those that hold most first. Every candidate whose approach came to an
/// end, force closure or not, closes anew at several depths, drawn back against its direction of
/// approach: where it is open `margin` away from the object, and neither open nor closed comes
/// within the margin of an obstacle. The depth at which it holds most is kept, or
/// the first one at which it holds six times the mass. What it holds is
/// quality.largestMass, and is at least options.holds times the mass (options.grasps.mass).
/// @param candidates of the object, whose frame is W
/// @param obstacles  in the same frame
/// @param arrives    candidates for which it says no are left out
[[nodiscard]] std::vector<Grasp> firmGrasps(const HandModel& hand,
                                            const GraspObject& object,
                                            std::span<const RigidBody> obstacles,
                                            const std::vector<Grasp>& candidates,
                                            const PickPlaceOptions& options,
                                            const ArrivesAt& arrives);

/// True if no link of the hand is nearer to a body than `margin`.
[[nodiscard]] bool isClear(const HandModel& hand,
                           const Eigen::Isometry3d& X_WH,
                           const std::vector<double>& positions,
                           std::span<const RigidBody> bodies,
                           double margin);
}  // namespace bullet_ccd::grasp
