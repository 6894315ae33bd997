/// Closing by time-of-impact queries alone: no simulation.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/closing/closing.h"

#include <span>

namespace bullet_ccd::grasp
{
/// A closing engine for the planner, one a thread (see CloseHand for the contract). Parts of the
/// hand that close independently (closingGroups(): fingers) are asked for their first contact one
/// by one, by an articulated query up to the limit of their next joint; the earliest contact of all
/// is taken, its links stop with the joints between them and the palm, and only the parts that
/// this changes are asked again. Contacts between parts are looked for up to that contact only.
///
/// Guarantee: as of articulatedToi(), so nothing touches nearer than a part of the tolerance at any
/// time of the closing, however far the joints turn. Status: Hit if a link was stopped, Separated
/// if all joints reached their limits; Overlapping if a link that closes intersects something at
/// the start; IterationLimit if a query gave up (positions: so far).
/// Hand and object must stay alive and unchanged between calls with the same addresses.
/// @param obstacles at rest in W beside the object, of which the hierarchies and the list itself
///        must outlive the engine; those out of reach of the swept boxes (sweptBoxes()) cost a test
///        of boxes each
[[nodiscard]] BULLET_CCD_API CloseHand kinematicClosing(std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::grasp
