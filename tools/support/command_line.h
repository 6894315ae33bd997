/// What the command lines have in common: how they begin, how they end, exit codes.
#pragma once

#include <functional>

namespace CLI
{
class App;
}

namespace bullet_ccd::tools
{
enum ExitCode
{
    kDone = 0,
    kNothingFound = 1,  ///< no grasp or no forces, or a check or criterion that failed
    kUsage = 2,
    kBadInput = 3,
};

struct ProgramText
{
    const char* name;
    const char* about;
    const char* footer;  ///< of the help
};

/// Reads the command line and runs what `addTo` has added to it, which leaves its exit code.
/// Exceptions become a line on stderr, and kUsage or kBadInput; so does output that cannot be
/// written, such as to a full disk.
[[nodiscard]] int runProgram(int argc,
                             char** argv,
                             const ProgramText& text,
                             const std::function<void(CLI::App& app, int& exitCode)>& addTo);
}  // namespace bullet_ccd::tools
