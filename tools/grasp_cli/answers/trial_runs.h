/// Trials of many grasps, on all cores.
#pragma once

#include "grasp/trial/grasp_trial.h"
#include "tools/support/stop_request.h"

#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// The protocols of lists such as "lift,six" and of single names.
/// Throws std::invalid_argument that names the option for a list in which a name is missing, and as
/// grasp::namedProtocol() does.
[[nodiscard]] std::vector<grasp::TrialProtocol> protocolsNamed(
    const std::vector<std::string>& lists, const std::string& option);

/// One entry per grasp and protocol.
using TrialRows = std::vector<std::vector<grasp::TrialResult>>;

/// Tries the grasps in their order. A grasp that was begun is finished; those behind the last one
/// that was begun before the stop have no row. Results do not depend on the number of threads.
/// @param jobs  threads; 0: one per core
/// Throws as runTrial() does.
[[nodiscard]] TrialRows runTrials(const grasp::HandModel& hand,
                                  const grasp::GraspObject& object,
                                  std::span<const grasp::Grasp* const> grasps,
                                  const std::vector<grasp::TrialProtocol>& protocols,
                                  const grasp::TrialOptions& options,
                                  int jobs,
                                  const StopRequest& stop);
}  // namespace bullet_ccd::tools
