#include "grasp/report/closing_spans.h"

#include "grasp/closing/closing_drives.h"
#include "grasp/closing/closing_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd::grasp
{
ClosingSpans closingSpans(const HandModel& hand, const Grasp& grasp, const ClosingOptions& options)
{
    ClosingSpans spans{.from = grasp.positions,
                       .joints = std::vector<ClosingSpan>(hand.robot.tree.size())};
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    if (preshape == nullptr)
    {
        return spans;
    }
    ClosingDrives drives(hand,
                         preshape->positions,
                         closingTurns(hand, closingGroups(hand), options),
                         closingSpeeds(hand, options));
    spans.from = drives.positions();
    if (grasp.positions.empty())
    {
        return spans;
    }
    std::vector<bool> hasBegun(spans.joints.size(), false);
    for (auto stop = grasp.stops.begin();;)
    {
        drives.beginNext();
        const double stopTime =
            stop != grasp.stops.end() ? stop->time : std::numeric_limits<double>::infinity();
        const double until = std::max(drives.time(), std::min(stopTime, drives.nextLimit()));
        if (!std::isfinite(until))
        {
            return spans;
        }
        for (std::size_t i = 0; i < spans.joints.size(); ++i)
        {
            if (drives.speeds()[i] != 0.0)
            {
                spans.joints[i].begin = hasBegun[i] ? spans.joints[i].begin : drives.time();
                spans.joints[i].end = until;
                hasBegun[i] = true;
            }
        }
        spans.pace.push_back(
            {spans.pace.back()[0] + drives.pace() * (until - drives.time()), until});
        drives.advanceTo(until);
        spans.end = until;
        for (; stop != grasp.stops.end() && stop->time <= until; ++stop)
        {
            drives.stopLink(stop->link, until, stop->byObject);
        }
    }
}
}  // namespace bullet_ccd::grasp
