/// Closing by time-of-impact queries alone, without simulation.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/closing/closing.h"

#include <span>

namespace bullet_ccd::grasp
{
/// A closing engine for the planner. Use one per thread. CloseHand states the contract.
///
/// Fingers that close independently are queried one by one for their first contact, up to the limit
/// of their next joint. The earliest contact of all is taken: its links stop, together with the
/// joints between them and the palm, and only the fingers that this changes are queried again.
/// Contacts between fingers are looked for up to that contact only.
///
/// Guarantee: as that of articulatedToi(), so no contact at any time of the closing, however far
/// the joints turn. A link stops with a part of the tolerance as gap. Status: Hit if a link was
/// stopped; Separated if all joints reached their limits; Overlapping if a closing link intersects
/// something at the start; IterationLimit if a query gave up, with the positions reached so far.
/// @param obstacles bodies at rest in W beside the object. Their hierarchies and the list itself
///                  must outlive the engine. An obstacle out of reach costs one test of boxes.
/// @pre hand and object stay alive and unchanged between calls with the same addresses
[[nodiscard]] BULLET_CCD_API CloseHand kinematicClosing(std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::grasp
