#include "benchmarks/soak/bullet_soak_report.h"

#include <cstdio>

namespace bullet_ccd::tests
{
void printCounters(const btCcdControl& control, double seconds)
{
    const btCcdCounters& counters = control.getCcdCounters();
    std::printf(
        "queries %lld, impacts %lld, sub-steps %lld, clamps %lld, lost time %.6f s in "
        "%.2f s, pairs that intersected already %lld, steps at the limit of impacts %lld, "
        "queries that gave up %lld, colliders not covered %lld\n",
        static_cast<long long>(counters.m_queries),
        static_cast<long long>(counters.m_impacts),
        static_cast<long long>(counters.m_subSteps),
        static_cast<long long>(counters.m_clamps),
        counters.m_lostTime,
        seconds,
        static_cast<long long>(counters.m_overlaps),
        static_cast<long long>(counters.m_eventLimits),
        static_cast<long long>(counters.m_iterationLimits),
        static_cast<long long>(counters.m_unsupported));
}

void printAudit(const AuditResult& seen, const std::string& deepest)
{
    std::printf("looked at %lld poses, %lld pairs of bodies near each other: %lld intersect\n",
                static_cast<long long>(seen.poses),
                static_cast<long long>(seen.pairs),
                static_cast<long long>(seen.intersecting));
    std::printf("deepest penetration: %.3e m\n", seen.worst.depth);
    if (!deepest.empty())
    {
        std::printf("%s\n", deepest.c_str());
    }
}
}  // namespace bullet_ccd::tests
