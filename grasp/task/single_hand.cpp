#include "grasp/task/single_hand.h"

#include "grasp/planner/weight_margin.h"
#include "grasp/quality/object_mass.h"
#include "grasp/task/firm_grasps.h"

#include <algorithm>
#include <map>
#include <vector>

namespace bullet_ccd::grasp
{
SingleHandSearch searchSingleHand(const HandModel& hand,
                                  const GraspObject& object,
                                  PickPlaceOptions options)
{
    options.holds = 0.0;
    options.grasps.efforts.clear();
    const double mass = massOf(object, options.grasps.mass).mass;
    SingleHandSearch search;
    for (const ApproachSource source : {ApproachSource::Mixed, ApproachSource::Pinch})
    {
        options.grasps.approach.source = source;
        std::vector<Grasp> grasps = planGrasps(
            hand, object, options.grasps, [] { return kinematicClosing(); }, {.stop = [&] {
                return options.stop.isDue();
            }});
        search.candidates += std::ptrdiff_t(grasps.size());
        std::vector<Grasp> farther =
            firmGrasps(hand, object, {}, grasps, options, [](const Grasp&) { return true; });
        std::erase_if(grasps,
                      [](const Grasp& grasp) { return grasp.reject != RejectReason::None; });
        std::ranges::move(farther, std::back_inserter(grasps));
        std::map<std::int64_t, double> held;  // of each candidate, the best
        for (const Grasp& grasp : grasps)
        {
            double& best = held[grasp.candidate];
            best = std::max(
                best,
                largestMassHeld(
                    hand, object, grasp, options.grasps.friction, pyramidEdges(options.grasps)));
        }
        search.forceClosures += std::ptrdiff_t(held.size());
        for (const auto& [candidate, most] : held)
        {
            search.holding += most >= mass ? 1 : 0;
            search.largestMass = std::max(search.largestMass, most);
        }
    }
    return search;
}
}  // namespace bullet_ccd::grasp
