/// What one hand alone can do with an object: the question that tasks of two hands begin with.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/task/pick_place.h"

#include <cstdint>

namespace bullet_ccd::grasp
{
struct SingleHandSearch
{
    std::int64_t candidates = 0;
    std::int64_t forceClosures = 0;  ///< candidates that are one where they stopped or farther back
    std::int64_t holding = 0;        ///< of these, those that hold the object's weight
    double largestMass = 0.0;        ///< that any of them holds [kg]
};

/// Looks for grasps of one hand that is alone with the object, in its favour: nothing is in its
/// way, no arm has to bring it there, it closes at every depth of firmGrasps(), and for the weight,
/// whichever way that pulls, all joints give their full effort (largestMassHeld()).
/// @param options of each of two searches: ApproachSource::Mixed, and ApproachSource::Pinch for
/// rims, handles and edges
[[nodiscard]] BULLET_CCD_API SingleHandSearch searchSingleHand(const HandModel& hand,
                                                               const GraspObject& object,
                                                               PickPlaceOptions options);
}  // namespace bullet_ccd::grasp
