#include "tools/support/progress_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <gmock/gmock.h>
#include <pty.h>
#include <string>
#include <thread>
#include <unistd.h>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::EndsWith;
using ::testing::HasSubstr;

/// While it lives, stderr is a terminal whose output can be read.
class Terminal
{
public:
    Terminal() : m_saved(::dup(STDERR_FILENO))
    {
        EXPECT_EQ(::openpty(&m_master, &m_slave, nullptr, nullptr, nullptr), 0);
        ::dup2(m_slave, STDERR_FILENO);
    }
    ~Terminal()
    {
        ::dup2(m_saved, STDERR_FILENO);
        for (const int descriptor : {m_saved, m_master, m_slave})
        {
            ::close(descriptor);
        }
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    /// What was written since; waits for something.
    [[nodiscard]] std::string read() const
    {
        std::array<char, 1000> buffer{};
        const ssize_t size = ::read(m_master, buffer.data(), buffer.size());
        return {buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
    }

private:
    int m_saved = -1;
    int m_master = -1;
    int m_slave = -1;
};

constexpr std::chrono::milliseconds kLongEnough(1100);

TEST(ProgressLine, RewritesItselfOnATerminalAndGoes)
{
    const Terminal terminal;
    {
        ProgressLine line(200, "queries", 100);
        line.show(101);  // too early
        std::this_thread::sleep_for(kLongEnough);
        line.show(150, ", 7 found");
        line.show(151);  // too soon after the other
        // Fifty took a second, so the other fifty take one more; what was there before took
        // nothing.
        const std::string text = terminal.read();
        EXPECT_THAT(text, HasSubstr("\r150/200 queries, 7 found, 1 s, 1 s left"));
        EXPECT_EQ(text.find("151"), std::string::npos);
    }
    EXPECT_THAT(terminal.read(), EndsWith("\r\x1b[K"));
}

TEST(ProgressLine, ShortRunsSayNothing)
{
    testing::internal::CaptureStderr();
    {
        ProgressLine line(2, "queries");
        line.show(1);
        line.show(2);
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}
}  // namespace
}  // namespace bullet_ccd::tools
