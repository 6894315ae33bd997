#include "tools/grasp_cli/progress.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

namespace bullet_ccd::tools
{
Progress::Progress(std::string label, std::int64_t total, bool quiet)
    : m_label(std::move(label)),
      m_total(total),
      m_quiet(quiet),
      m_terminal(::isatty(STDERR_FILENO) != 0),
      m_start(std::chrono::steady_clock::now())
{
}

Progress::~Progress()
{
    if (m_terminal && !m_quiet && m_done > 0)
    {
        std::fputc('\n', stderr);
    }
}

void Progress::add(const grasp::Grasp& grasp)
{
    const std::scoped_lock lock(m_mutex);
    count(grasp);
    const std::int64_t step = std::max<std::int64_t>(1, (m_total + 9) / 10);
    if (!m_quiet && (m_terminal || m_done % step == 0 || m_done == m_total))
    {
        show();
    }
}

void Progress::addKnown(const grasp::Grasp& grasp)
{
    const std::scoped_lock lock(m_mutex);
    count(grasp);
}

void Progress::count(const grasp::Grasp& grasp)
{
    ++m_done;
    m_found += grasp.reject == grasp::RejectReason::None ? 1 : 0;
}

void Progress::show()
{
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - m_start;
    fmt::print(stderr,
               "{}{}: {}/{} candidates, {} force closure{}, {:.1f} s{}",
               m_terminal ? "\r" : "",
               m_label,
               m_done,
               m_total,
               m_found,
               m_found == 1 ? "" : "s",
               elapsed.count(),
               m_terminal ? "\x1b[K" : "\n");
    std::fflush(stderr);
}
}  // namespace bullet_ccd::tools
