/// Progress of long runs on a terminal.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>

namespace bullet_ccd::tools
{
/// One line on stderr that rewrites itself, from a second after the start; nothing if stderr is not
/// a terminal. Thread-safe.
class ProgressLine
{
public:
    explicit ProgressLine(std::size_t total);
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    void show(std::size_t done);

private:
    using Clock = std::chrono::steady_clock;

    std::size_t m_total = 0;
    bool m_terminal = false;
    bool m_shown = false;
    Clock::time_point m_start;
    Clock::time_point m_next;
    std::mutex m_mutex;
};
}  // namespace bullet_ccd::tools
