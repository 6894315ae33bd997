/// The verbs of the program `grasp`. Each adds itself to the command line; when it is chosen it
/// runs and leaves its exit code.
#pragma once

#include "grasp/planner/grasp_planner.h"
#include "tools/option_values.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <string>

namespace bullet_ccd::tools
{
enum ExitCode
{
    kFound = 0,
    kNothingFound = 1,  ///< no grasp or no forces, or a check or criterion that failed
    kUsage = 2,
    kBadInput = 3,
};

void addPlanCommand(CLI::App& app, int& exitCode);
void addCloseCommand(CLI::App& app, int& exitCode);
void addCheckCommand(CLI::App& app, int& exitCode);
void addForceCommand(CLI::App& app, int& exitCode);
void addHandCommand(CLI::App& app, int& exitCode);
/// The verb `check` below the verb `hand`.
void addHandCheckCommand(CLI::App& hand, int& exitCode);
void addQualityCommand(CLI::App& app, int& exitCode);

/// Options of all that plans: candidates, seed, jobs, engine, quality.
void addPlannerOptions(CLI::App& command, grasp::PlannerOptions& options);
/// Those of them that say where the hand comes from.
void addApproachOptions(CLI::App& command, grasp::ApproachOptions& options);
/// Its parts for verbs that search nothing.
void addEngineOption(CLI::App& command, grasp::PlannerOptions& options);
void addQualityOptions(CLI::App& command, grasp::PlannerOptions& options);
}  // namespace bullet_ccd::tools
