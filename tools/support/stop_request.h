/// Long commands that end early and keep what they have.
#pragma once

#include "bullet_ccd/math/stop_condition.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace CLI
{
class App;
}

namespace bullet_ccd::tools
{
/// While it lives, SIGINT (Ctrl-C) and SIGTERM ask the command to stop instead of ending the
/// process; a second one ends it. A signal that the process was started to ignore stays ignored.
/// One at a time.
class StopRequest
{
public:
    /// @param timeLimit  [s] from now on; 0: none
    explicit StopRequest(double timeLimit = 0.0);
    ~StopRequest();
    StopRequest(const StopRequest&) = delete;
    StopRequest& operator=(const StopRequest&) = delete;

    /// A signal came. Thread-safe.
    [[nodiscard]] bool isInterrupted() const;
    /// A signal came, or the time is over. Thread-safe.
    [[nodiscard]] bool isDue() const { return m_condition.isDue(); }
    /// For queries, so that a long one ends, too. Not to be used after this object.
    [[nodiscard]] const StopCondition& condition() const { return m_condition; }

    /// To be called last. If not everything was done, prints "<command>: stopped after 3 of 10
    /// queries" to stderr. Returns `exitCode`, or, if it was a signal that stopped the command, 128
    /// + its number, as shells have it: 130 after Ctrl-C.
    [[nodiscard]] int finish(std::string_view command,
                             std::size_t done,
                             std::size_t total,
                             std::string_view things,
                             int exitCode) const;

private:
    StopCondition m_condition;
};

/// --time-limit. `what` says what ends, for example "Begin no further query".
void addTimeLimitOption(CLI::App& command, double& timeLimit, const std::string& what);
}  // namespace bullet_ccd::tools
