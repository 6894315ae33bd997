/// Whether a grasp holds the weight of its object, whichever way that pulls.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <span>

namespace bullet_ccd::grasp
{
/// The largest mass [kg] that the contacts hold against gravity in every direction, the hand still,
/// with Coulomb friction and joint torques within the efforts of the joints; infinite if they do
/// not limit it, 0 if some direction cannot be held at all.
///
/// The largest weight is found in the 12 directions of an icosahedron by linear programs over
/// inscribed friction pyramids. What is held in three directions is held between them, since forces
/// can be mixed, so the result is never above the truth of that model: it is the radius of the
/// largest ball within the polyhedron of these weights. The hand is taken to answer each direction
/// by forces of its own.
/// @param efforts  one entry per independent joint [N m or N]; empty: those of jointEfforts(),
/// which
///                 assumes some where the robot states none that a finger has
/// Throws std::invalid_argument as handJacobian() does, and for another number of efforts.
[[nodiscard]] BULLET_CCD_API double largestMassHeld(const HandModel& hand,
                                                    const GraspObject& object,
                                                    const Grasp& grasp,
                                                    double friction,
                                                    int coneEdges,
                                                    std::span<const double> efforts = {});
}  // namespace bullet_ccd::grasp
