/// The option --fingers: all at once or one by one.
#pragma once

#include "grasp/closing/closing.h"

#include <CLI/CLI.hpp>

namespace bullet_ccd::tools
{
/// Names of fingers are not looked at: see requireFingers().
void addFingersOption(CLI::App& command, grasp::ClosingOptions& closing);
}  // namespace bullet_ccd::tools
