#include "tools/support/stop_request.h"

#include "tools/support/option_values.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::array kStopSignals{SIGINT, SIGTERM};
constexpr int kSignalBase = 128;

std::atomic<int> stopSignal = 0;
std::atomic<bool> isSignalled = false;
// So that a handler may set them.
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

extern "C" void noteSignal(int signal)
{
    stopSignal = signal;
    isSignalled = true;
}
}  // namespace

StopRequest::StopRequest(double timeLimit)
    : m_condition(timeLimit > 0.0 ? stopAfter(timeLimit) : StopCondition{})
{
    m_condition.isCancelled = &isSignalled;
    stopSignal = 0;
    isSignalled = false;
    for (const int signal : kStopSignals)
    {
        struct sigaction action = {};
        ::sigaction(signal, nullptr, &action);
        if (action.sa_handler != SIG_IGN)
        {
            action = {};
            action.sa_handler = noteSignal;
            action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
            ::sigaction(signal, &action, nullptr);
        }
    }
}

StopRequest::~StopRequest()
{
    for (const int signal : kStopSignals)
    {
        struct sigaction action = {};
        ::sigaction(signal, nullptr, &action);
        if (action.sa_handler == noteSignal)
        {
            ::signal(signal, SIG_DFL);
        }
    }
}

bool StopRequest::isInterrupted() const
{
    return stopSignal != 0;
}

int StopRequest::finish(std::string_view command,
                        std::size_t done,
                        std::size_t total,
                        std::string_view things,
                        int exitCode) const
{
    if (done >= total)
    {
        return exitCode;
    }
    fmt::print(stderr, "{}: stopped after {} of {} {}\n", command, done, total, things);
    return isInterrupted() ? kSignalBase + stopSignal : exitCode;
}

void addTimeLimitOption(CLI::App& command, double& timeLimit, const std::string& what)
{
    command
        .add_option("--time-limit",
                    timeLimit,
                    what + " after S seconds, and keep what was done; 0 sets no limit.")
        ->type_name("S")
        ->check(within(0.0, 1e9))
        ->capture_default_str();
}
}  // namespace bullet_ccd::tools
