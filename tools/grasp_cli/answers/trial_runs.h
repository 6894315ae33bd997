/// Trials of many grasps, on all cores.
#pragma once

#include "grasp/trial/grasp_trial.h"
#include "tools/support/stop_request.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// The protocols of lists such as "lift,six" and of single names.
/// Throws std::invalid_argument that names the option for a list in which a name is missing, and
/// for two protocols of one name, and as grasp::namedProtocol() does.
[[nodiscard]] std::vector<grasp::TrialProtocol> protocolsNamed(
    const std::vector<std::string>& lists, const std::string& option);

/// What became of one grasp.
struct TrialRow
{
    /// One entry per protocol; none for a trial that was not begun, or was stopped before a pull
    /// of it ended.
    std::vector<std::optional<grasp::TrialResult>> results;
    std::string error;  ///< why it could not be tried; else empty

    /// Everything that was asked is known.
    [[nodiscard]] bool isDone() const;
};

/// Gives who watches the trial of the k-th grasp by the p-th protocol; called by any thread.
using TrialWatch =
    std::function<std::function<void(const grasp::TrialFrame&)>(std::size_t k, std::size_t p)>;

/// Whose penetration is looked at: what is simulated, or what that is a smaller model of.
struct JudgedModels
{
    const grasp::HandModel& hand;
    const grasp::GraspObject& object;
};

/// Tries the grasps in their order. A stop ends the trials that run; those that ended before are
/// kept, and grasps that were not begun have no row. Results do not depend on the number of
/// threads. A grasp that cannot be tried has an error and does not end the others.
/// @param jobs  threads; 0: one per core
/// @param ended  is called after each trial, never by two threads at once, with the rows so far
[[nodiscard]] std::vector<TrialRow> runTrials(
    const grasp::HandModel& hand,
    const grasp::GraspObject& object,
    std::span<const grasp::Grasp* const> grasps,
    const std::vector<grasp::TrialProtocol>& protocols,
    grasp::TrialOptions options,
    int jobs,
    const StopRequest& stop,
    const JudgedModels& judged,
    const std::function<void(const std::vector<TrialRow>&)>& ended = {},
    const TrialWatch& watch = {});
}  // namespace bullet_ccd::tools
