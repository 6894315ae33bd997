/// The parts of a hand that close independently of each other: usually its fingers.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/closing/closing.h"
#include "grasp/hand/hand_model.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
using LinkPair = std::pair<std::int32_t, std::int32_t>;

/// Links of which the motion depends on the same closing joints.
struct ClosingGroup
{
    std::vector<std::int32_t> links;
    /// Pairs of two of its links, or of one and a link that rests while the hand closes.
    std::vector<LinkPair> selfPairs;
    /// One entry a link of the hand: hierarchies of the links and of what they are paired with,
    /// else null.
    std::vector<const SsvTree*> linkTrees;
};

struct ClosingGroups
{
    std::vector<ClosingGroup> groups;
    std::vector<std::int32_t> groupOf;  ///< one entry a link; kNone for one that rests
    std::vector<LinkPair> crossPairs;   ///< of links of two groups
    std::vector<const SsvTree*> crossTrees;
};

/// When each link moves if the parts of the hand close one after the other (ClosingOptions::order):
/// one entry a link, from 0; kNone for one that rests. Empty: all at once.
/// Throws std::invalid_argument for a finger that the hand does not have.
[[nodiscard]] BULLET_CCD_API std::vector<std::int32_t> closingTurns(const HandModel& hand,
                                                                    const ClosingGroups& groups,
                                                                    const ClosingOptions& options);

/// Two closing joints belong together if one moves the other or follows it (mimic), or if some
/// third joint belongs with both.
[[nodiscard]] BULLET_CCD_API ClosingGroups closingGroups(const HandModel& hand);
}  // namespace bullet_ccd::grasp
