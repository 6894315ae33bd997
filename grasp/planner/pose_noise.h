/// What is left of a grasp if the object is not quite where it was thought to be.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/planner/grasp_planner.h"

namespace bullet_ccd::grasp
{
/// Normally distributed errors of the object's pose, about its centre of mass.
struct PoseNoise
{
    double position = 0.002;  ///< standard deviation along each axis [m]
    double rotation = 0.02;   ///< standard deviation of each component of the rotation vector [rad]
    int trials = 50;
    std::uint64_t seed = 1;
};

/// Outcome of the repeated closings.
struct BULLET_CCD_API PoseRobustness
{
    int trials = 0;
    int forceClosures = 0;
    int sameLinks = 0;             ///< in which the very links are in contact that were
    std::vector<double> epsilons;  ///< one a trial, ascending; 0 where nothing was held
    [[nodiscard]] double medianEpsilon() const;
};

/// Repeats the grasp: for every trial the object's pose is off by a random error, while the hand
/// goes the way that it went, stops at its first contact if that comes before the way is done, and
/// closes from the grasp's preshape. Every trial is a certified closing, as closeAtPose() does it.
/// The same seed gives the same errors.
/// Throws std::invalid_argument if the hand has no preshape of the grasp's name, or for negative
/// numbers.
[[nodiscard]] BULLET_CCD_API PoseRobustness poseRobustness(const HandModel& hand,
                                                           const GraspObject& object,
                                                           const Grasp& grasp,
                                                           const PoseNoise& noise,
                                                           const PlannerOptions& options,
                                                           const CloseHand& close);
}  // namespace bullet_ccd::grasp
