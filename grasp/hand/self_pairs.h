/// Which links of a hand have to be tested against each other.
#pragma once

#include "grasp/hand/hand_model.h"

#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// Links this close in a preshape count as overlapping there [m].
inline constexpr double kPreshapeOverlap = 1e-4;

/// Fills `hand.selfPairs` from everything else in the hand; `disabled` holds pairs of links in any
/// order. Notes pairs that overlap in a preshape.
void setSelfPairs(HandModel& hand,
                  const std::vector<std::pair<std::int32_t, std::int32_t>>& disabled);

/// True if both links have geometry and two closing joints or more lie between them: neighbours
/// overlap about their joint by design, and its limits keep them apart.
[[nodiscard]] bool canTouch(const HandModel& hand, std::int32_t first, std::int32_t second);

/// True if links overlap that do not so at `reference`: pairs with two movable joints or more
/// between them. Positions have one entry per link.
[[nodiscard]] bool selfOverlaps(const HandModel& hand,
                                const std::vector<double>& positions,
                                const std::vector<double>& reference);
}  // namespace bullet_ccd::grasp
