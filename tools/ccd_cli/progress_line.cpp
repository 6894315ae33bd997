#include "tools/ccd_cli/progress_line.h"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace bullet_ccd::tools
{
ProgressLine::ProgressLine(std::size_t total)
    : m_total(total),
      m_terminal(::isatty(STDERR_FILENO) != 0),
      m_start(Clock::now()),
      m_next(m_start + std::chrono::seconds(1))
{
}

ProgressLine::~ProgressLine()
{
    if (m_shown)
    {
        fmt::print(stderr, "\r\x1b[K");
        std::fflush(stderr);
    }
}

void ProgressLine::show(std::size_t done)
{
    if (!m_terminal)
    {
        return;
    }
    const std::scoped_lock lock(m_mutex);
    const Clock::time_point now = Clock::now();
    if (now < m_next)
    {
        return;
    }
    const double elapsed = std::chrono::duration<double>(now - m_start).count();
    const double left = elapsed * static_cast<double>(m_total - done) / static_cast<double>(done);
    fmt::print(
        stderr, "\r{}/{} queries, {:.0f} s, {:.0f} s left\x1b[K", done, m_total, elapsed, left);
    std::fflush(stderr);
    m_shown = true;
    m_next = now + std::chrono::milliseconds(200);
}
}  // namespace bullet_ccd::tools
