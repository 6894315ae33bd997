/// When each joint of a hand moved while it closed.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/closing/closing.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <array>
#include <vector>

namespace bullet_ccd::grasp
{
/// Closing moves each joint at constant speed from its first position at `begin` to its last one at
/// `end` [s]; a joint that never moved has begin = end.
struct ClosingSpan
{
    double begin = 0.0;
    double end = 0.0;
};

struct ClosingSpans
{
    std::vector<double> from;         ///< positions at time 0, one entry a link [rad or m]
    std::vector<ClosingSpan> joints;  ///< one entry a link
    double end = 0.0;                 ///< of the closing [s]
    /// Corners (shown, time) [s] of a line from (0, 0) to the end: in shown time the fastest of the
    /// joints that move has its usual speed, however slowly it closes.
    std::vector<std::array<double, 2>> pace{{0.0, 0.0}};
};

/// Goes through the closing again by the stops that the grasp has on record, without any query. A
/// grasp that never closed gets its preshape and no motion; if the hand does not have the preshape,
/// `from` is grasp.positions.
[[nodiscard]] BULLET_CCD_API ClosingSpans closingSpans(const HandModel& hand,
                                                       const Grasp& grasp,
                                                       const ClosingOptions& options);
}  // namespace bullet_ccd::grasp
