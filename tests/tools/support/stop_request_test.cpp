#include "tools/support/stop_request.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
bool isDefault(int signal)
{
    struct sigaction action = {};
    ::sigaction(signal, nullptr, &action);
    return action.sa_handler == SIG_DFL;
}

/// What finish() returns, and what it says.
struct End
{
    int exitCode;
    std::string line;
};

End endOf(const StopRequest& stop, std::size_t done)
{
    testing::internal::CaptureStderr();
    const int exitCode = stop.finish("program verb", done, 10, "things", 7);
    return {.exitCode = exitCode, .line = testing::internal::GetCapturedStderr()};
}

TEST(StopRequest, IsNotDueByItself)
{
    const StopRequest stop;
    EXPECT_FALSE(stop.isDue());
    EXPECT_EQ(endOf(stop, 10).exitCode, 7);
    EXPECT_EQ(endOf(stop, 10).line, "");
}

TEST(StopRequest, ATimeLimitKeepsTheExitCode)
{
    const StopRequest stop(1e-9);
    EXPECT_TRUE(stop.isDue());
    EXPECT_FALSE(stop.isInterrupted());
    EXPECT_EQ(endOf(stop, 3).exitCode, 7);
    EXPECT_EQ(endOf(stop, 3).line, "program verb: stopped after 3 of 10 things\n");
    EXPECT_FALSE(StopRequest(1e9).isDue());
}

TEST(StopRequest, ASignalStopsAndIsToldByTheExitCode)
{
    for (const auto& [signal, exitCode] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)})
    {
        {
            const StopRequest stop;
            ::raise(signal);
            EXPECT_TRUE(stop.isDue());
            EXPECT_TRUE(stop.isInterrupted());
            EXPECT_TRUE(isDefault(signal)) << "a second signal must end the process";
            EXPECT_EQ(endOf(stop, 3).exitCode, exitCode);
            EXPECT_EQ(endOf(stop, 10).exitCode, 7) << "everything was done all the same";
        }
        EXPECT_TRUE(isDefault(SIGINT) && isDefault(SIGTERM));
        EXPECT_FALSE(StopRequest().isDue());
    }
}

TEST(StopRequest, AnIgnoredSignalStaysIgnored)
{
    ::signal(SIGINT, SIG_IGN);
    {
        const StopRequest stop;
        ::raise(SIGINT);
        EXPECT_FALSE(stop.isDue());
    }
    ::raise(SIGINT);  // would end this process if it were not ignored any more
    ::signal(SIGINT, SIG_DFL);
}
}  // namespace
}  // namespace bullet_ccd::tools
