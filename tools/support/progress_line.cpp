#include "tools/support/progress_line.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::chrono::seconds kFirst(1);
constexpr std::chrono::milliseconds kNext(200);
constexpr std::chrono::seconds kElsewhere(10);
}  // namespace

ProgressLine::ProgressLine(std::size_t total, std::string things, std::size_t before)
    : m_total(total),
      m_things(std::move(things)),
      m_before(before),
      m_terminal(::isatty(STDERR_FILENO) != 0),
      m_start(Clock::now()),
      m_next(m_start + (m_terminal ? kFirst : kElsewhere))
{
}

ProgressLine::~ProgressLine()
{
    if (m_shown && m_terminal)
    {
        fmt::print(stderr, "\r\x1b[K");
        std::fflush(stderr);
    }
}

void ProgressLine::show(std::size_t done, std::string_view more)
{
    const std::scoped_lock lock(m_mutex);
    const Clock::time_point now = Clock::now();
    if (now < m_next)
    {
        return;
    }
    const double elapsed = std::chrono::duration<double>(now - m_start).count();
    const double each = elapsed / static_cast<double>(std::max<std::size_t>(1, done - m_before));
    fmt::print(stderr,
               "{}{}/{} {}{}, {:.0f} s, {:.0f} s left{}",
               m_terminal ? "\r" : "",
               done,
               m_total,
               m_things,
               more,
               elapsed,
               each * static_cast<double>(m_total - done),
               m_terminal ? "\x1b[K" : "\n");
    std::fflush(stderr);
    m_shown = true;
    m_next = now + (m_terminal ? Clock::duration(kNext) : Clock::duration(kElsewhere));
}
}  // namespace bullet_ccd::tools
