/// Options of what plans, shared by the verbs of `grasp` and by the programs that measure plans.
#pragma once

#include "grasp/planner/grasp_planner.h"

#include <CLI/CLI.hpp>
#include <span>
#include <string>

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

/// Links stop anywhere within the accuracy [m], and what stopped them is among their contacts.
void setAccuracy(grasp::ClosingOptions& closing, double accuracy);
/// The same by the scenes, if they state one. Throws as accuracyOf().
void setAccuracyOfScenes(grasp::ClosingOptions& closing, std::span<const std::string> scenes);
}  // namespace bullet_ccd::tools
