/// Progress of long runs on stderr.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>

namespace bullet_ccd::tools
{
/// On a terminal, one line that rewrites itself from a second after the start and goes at the end;
/// elsewhere, a line every ten seconds. Thread-safe.
class ProgressLine
{
public:
    /// @param things  what is counted, for example "queries"
    /// @param before  how many of them an earlier run has done; they say nothing about the time
    /// left
    ProgressLine(std::size_t total, std::string things, std::size_t before = 0);
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    /// @param done  with those of an earlier run
    /// @param more  stands behind the count, for example ", 3 found"
    void show(std::size_t done, std::string_view more = {});

private:
    using Clock = std::chrono::steady_clock;

    std::size_t m_total = 0;
    std::string m_things;
    std::size_t m_before = 0;
    bool m_terminal = false;
    bool m_shown = false;
    Clock::time_point m_start;
    Clock::time_point m_next;
    std::mutex m_mutex;
};
}  // namespace bullet_ccd::tools
