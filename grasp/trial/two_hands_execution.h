/// Do two hands lift what they are planned to lift? Both arms and hands carry the plan out in a
/// Bullet world.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/task/two_hands.h"
#include "grasp/trial/plan_execution.h"

namespace bullet_ccd::grasp
{
struct LiftResult
{
    bool succeeded = false;
    bool stopped = false;        ///< ExecutionOptions::stop ended it: it says nothing
    std::string reason;          ///< why not
    double risen = 0.0;          ///< of the object's centre of mass, from where it stood [m]
    double missed = 0.0;         ///< how far that is from where the lift brings it [m]
    double turned = 0.0;         ///< by which the object has turned [rad]
    double leastDistance = 0.0;  ///< of what may not intersect, at 60 samples a second [m]
    double seconds = 0.0;        ///< of simulated time
    double inexact = 0.0;        ///< share of the solver's answers that are not exact
};

/// The legs are followed as they are timed. After the hands have closed, all joints of arms and
/// hands squeeze for half a second (TwoHandPlan::squeeze), as stiff as that says, and the object is
/// lifted and held for a second. It succeeded if the object is within placeTolerance of where the
/// lift brings it, has turned by no more than 5 degrees, and at no sample did two bodies or links
/// intersect that the plan tests.
/// @param options  mass, friction, rate, skin, skinStiffness, placeTolerance and stop count
/// @pre there are legs
[[nodiscard]] BULLET_CCD_API LiftResult executeLift(const TwoHandTask& task,
                                                    const TwoHandPlan& plan,
                                                    const ExecutionOptions& options = {});
}  // namespace bullet_ccd::grasp
