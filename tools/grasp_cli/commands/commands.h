/// The verbs of the program `grasp`. Each adds itself to the command line; when it is chosen it
/// runs and leaves its exit code.
#pragma once

#include "tools/support/command_line.h"
#include "tools/support/option_values.h"

#include <CLI/CLI.hpp>

namespace bullet_ccd::tools
{
void addPlanCommand(CLI::App& app, int& exitCode);
void addCloseCommand(CLI::App& app, int& exitCode);
void addCheckCommand(CLI::App& app, int& exitCode);
void addExportCommand(CLI::App& app, int& exitCode);
void addForceCommand(CLI::App& app, int& exitCode);
void addHandCommand(CLI::App& app, int& exitCode);
/// The verb `check` below the verb `hand`.
void addHandCheckCommand(CLI::App& hand, int& exitCode);
void addQualityCommand(CLI::App& app, int& exitCode);
void addTaskCommand(CLI::App& app, int& exitCode);
/// The verbs `bimanual`, `clutter` and `scene` below the verb `task`.
void addBimanual(CLI::App& task, int& exitCode);
void addClutter(CLI::App& task, int& exitCode);
void addScene(CLI::App& task, int& exitCode);
void addTrialCommand(CLI::App& app, int& exitCode);
}  // namespace bullet_ccd::tools
