/// Options from a file.
#pragma once

#include <CLI/CLI.hpp>

namespace bullet_ccd::tools
{
/// Gives a command, and the commands below it, --config FILE and --print-config. To be called when
/// all its other options have been added.
///
/// FILE is a YAML map. A key is the long name of an option without dashes (of FILE in `grasp check
/// FILE`: file), its value what stands behind the option on the command line; a list where the
/// option takes several values or may be repeated; true or false for a flag. What the command line
/// gives wins. Values are checked as those on the command line are.
///
/// While the command line is parsed, std::runtime_error "<file>:<line>: <key>: <what>: <remedy>" is
/// thrown for a file that is no such map. --print-config writes all options that have a value to
/// stdout, as such a file, and ends the parse with CLI::Success.
void addConfigOptions(CLI::App& command);
}  // namespace bullet_ccd::tools
