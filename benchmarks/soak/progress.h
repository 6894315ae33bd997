/// How far a long run has come, and how long it may still take.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>
#include <unistd.h>

namespace bullet_ccd::benchmarks
{
/// On a terminal one line that rewrites itself every second, else a line every minute.
class Progress
{
public:
    explicit Progress(double total) : m_total(total) {}
    ~Progress()
    {
        if (m_terminal && m_shown)
        {
            std::printf("\n");
        }
    }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void show(double done, const std::string& what)
    {
        const Clock::time_point now = Clock::now();
        if (now < m_next || done <= 0.0)
        {
            return;
        }
        m_next = now + std::chrono::seconds(m_terminal ? 1 : 60);
        m_shown = true;
        const double elapsed = std::chrono::duration<double>(now - m_start).count();
        std::printf("%s%.1f %%, %.0f s, about %.0f s to go: %s%s",
                    m_terminal ? "\r\033[K" : "",
                    100.0 * done / m_total,
                    elapsed,
                    elapsed * (m_total - done) / done,
                    what.c_str(),
                    m_terminal ? "" : "\n");
        std::fflush(stdout);
    }

private:
    using Clock = std::chrono::steady_clock;

    double m_total;
    bool m_terminal = ::isatty(STDOUT_FILENO) != 0;
    bool m_shown = false;
    Clock::time_point m_start = Clock::now();
    Clock::time_point m_next = m_start + std::chrono::seconds(2);
};
}  // namespace bullet_ccd::benchmarks
