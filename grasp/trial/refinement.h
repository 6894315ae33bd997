/// What to do about a grasp that did not hold.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/trial/grasp_trial.h"

namespace bullet_ccd::grasp
{
/// Closes the hand anew, as closeAtPose() does, jaws on one motor centred, where its approach and
/// its pose are moved
///   - by how far the object had moved in the hand when it was no longer held (TrialResult::moved),
///     and by half of that: the hand goes where the object went;
///   - across the approach so that the mean of its contacts comes to the object's centre of mass,
///     and by half of that: what is lost by its weight is often held beside its centre.
/// @param result     of a trial of the grasp that failed
/// @param obstacles  as of closeAtPose()
/// @return           of these that which holds the largest mass in any direction, with the number
///                   and the source of the old grasp; rejected if none is a force closure
/// Throws std::invalid_argument if the hand has no preshape of the grasp's name.
[[nodiscard]] BULLET_CCD_API Grasp refinedGrasp(const HandModel& hand,
                                                const GraspObject& object,
                                                const Grasp& grasp,
                                                const TrialResult& result,
                                                const PlannerOptions& options,
                                                const CloseHand& close,
                                                std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::grasp
