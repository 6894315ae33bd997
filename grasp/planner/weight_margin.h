/// Whether a grasp holds the weight of its object, whichever way that pulls.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

namespace bullet_ccd::grasp
{
/// The largest mass [kg] that the contacts hold against gravity in every direction, the hand still,
/// with Coulomb friction and joint torques within the efforts of the robot; infinite if the hand
/// states no efforts that limit it, 0 if some direction cannot be held at all.
///
/// The largest weight is found in the 12 directions of an icosahedron by linear programs over
/// inscribed friction pyramids. What is held in three directions is held between them, since forces
/// can be mixed, so the result is never above the truth of that model: it is the radius of the
/// largest ball within the polyhedron of these weights. The hand is taken to answer each direction
/// by forces of its own.
/// Throws std::invalid_argument as handJacobian() does.
[[nodiscard]] BULLET_CCD_API double largestMassHeld(const HandModel& hand,
                                                    const GraspObject& object,
                                                    const Grasp& grasp,
                                                    double friction,
                                                    int coneEdges);
}  // namespace bullet_ccd::grasp
