/// Options of what plans, shared by the verbs of `grasp` and by the programs that measure plans.
#pragma once

#include "grasp/planner/grasp_planner.h"

#include <CLI/CLI.hpp>

namespace bullet_ccd::tools
{
/// Options of all that plans: candidates, seed, jobs, engine, quality.
void addPlannerOptions(CLI::App& command, grasp::PlannerOptions& options);

/// Those of them that say where the hand comes from.
void addApproachOptions(CLI::App& command, grasp::ApproachOptions& options);

/// Parts for verbs that search nothing.
void addEngineOption(CLI::App& command, grasp::PlannerOptions& options);
void addQualityOptions(CLI::App& command, grasp::PlannerOptions& options);

/// --fingers and --closing-speeds. Names are not looked at: see requireFingers().
void addFingersOption(CLI::App& command, grasp::ClosingOptions& closing);
}  // namespace bullet_ccd::tools
