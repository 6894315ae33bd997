/// Progress of a plan on stderr.
#pragma once

#include "grasp/grasp_types.h"

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace bullet_ccd::tools
{
/// On a terminal one line that rewrites itself, elsewhere a line for every tenth. Thread-safe.
class Progress
{
public:
    /// @param label stands in front of every line
    Progress(std::string label, std::int64_t total, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void add(const grasp::Grasp& grasp);
    /// Counts a candidate of an earlier run without a line.
    void addKnown(const grasp::Grasp& grasp);

private:
    void count(const grasp::Grasp& grasp);
    void show();

    std::string m_label;
    std::int64_t m_total = 0;
    std::int64_t m_done = 0;
    std::int64_t m_found = 0;
    bool m_quiet = false;
    bool m_terminal = false;
    std::chrono::steady_clock::time_point m_start;
    std::mutex m_mutex;
};
}  // namespace bullet_ccd::tools
