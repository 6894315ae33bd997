/// What simulated trials make of a plan.
#pragma once

#include "grasp/formats/grasp_file.h"
#include "tools/grasp_cli/plan/plan_run.h"
#include "tools/support/stop_request.h"

#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct PlanTrials
{
    std::vector<std::string> protocols;  ///< names, files and lists of both
    int tried = 10;                      ///< so many of the best force closures
    int refine = 0;                      ///< rounds after trials that failed
    bool brief = false;                  ///< as TrialOptions
};

struct TriedCount
{
    std::size_t count = 0;     ///< grasps to try
    std::size_t done = 0;      ///< of those
    std::size_t improved = 0;  ///< that hold in more trials since they were refined
};

/// Tries the best grasps in simulations and ranks those that held in more protocols first, the
/// others of them as before, and what was not tried behind. Those that failed are refined
/// (grasp/trial/refinement.h) round by round; what then holds in more protocols takes their place.
/// The description gets the outcomes.
/// @param obstacles  of the plan
[[nodiscard]] TriedCount tryGrasps(const PlanTrials& trials,
                                   std::span<const RigidBody> obstacles,
                                   bool quiet,
                                   const StopRequest& stop,
                                   PlanRun& run,
                                   grasp::GraspRun& description);
}  // namespace bullet_ccd::tools
