#include "benchmarks/soak/bullet_soaks.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "robots/shapes/household_objects.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <optional>

namespace bullet_ccd::benchmarks
{
using namespace reference;

HouseholdObject makeHouseholdObject(std::size_t number, std::uint64_t seed, double density)
{
    const std::vector<std::string>& families = shapes::objectFamilies();
    HouseholdObject object;
    object.name = families[number % families.size()];
    const std::optional<std::uint64_t> size =
        number < families.size() ? std::nullopt : std::optional(seed);
    TriangleMesh mesh = shapes::makeObject(object.name, size, 2.0);
    static_cast<void>(examples::putIntoPrincipalAxes(mesh));
    object.mass = density * massProperties(mesh).volume;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        object.reach = std::max(object.reach, vertex.norm());
    }
    object.audit = std::make_shared<const AuditMesh>(mesh);
    object.tree = std::make_shared<const SsvTree>(buildSsvTree(std::move(mesh)));
    return object;
}

std::map<std::string, std::int64_t> countsOf(const btCcdControl& control, const AuditResult& seen)
{
    const btCcdCounters& counters = control.getCcdCounters();
    return {{"queries", counters.m_queries},
            {"impacts", counters.m_impacts},
            {"sub-steps", counters.m_subSteps},
            {"clamps", counters.m_clamps},
            {"lost time [us]", std::llround(1e6 * counters.m_lostTime)},
            {"pairs that intersected already", counters.m_overlaps},
            {"steps at the limit of impacts", counters.m_eventLimits},
            {"queries that gave up", counters.m_iterationLimits},
            {"colliders not covered", counters.m_unsupported},
            {"poses looked at", seen.poses},
            {"pairs of bodies near each other", seen.pairs},
            {"intersections", seen.intersecting}};
}

void printWorld(const std::string& what,
                const WorldAudit::Busiest& busiest,
                const std::vector<std::string>& names,
                const std::map<std::string, std::int64_t>& counts)
{
    fmt::print("{}\n", what);
    if (busiest.bodyA != kNone && busiest.bodyB != kNone)
    {
        fmt::print("  most impacts: {} of {} and {}\n",
                   busiest.impacts,
                   names[static_cast<std::size_t>(busiest.bodyA)],
                   names[static_cast<std::size_t>(busiest.bodyB)]);
    }
    std::string line = " ";
    for (const auto& [name, number] : counts)
    {
        line += fmt::format(" {} {},", name, number);
    }
    line.back() = '\n';
    fmt::print("{}", line);
    std::fflush(stdout);
}

Judgement judgementOf(const AuditResult& seen,
                      const std::vector<std::string>& names,
                      const std::string& otherwise)
{
    if (seen.clean() && otherwise.empty())
    {
        return {};
    }
    return {.verdict = Verdict::Missed,
            .time = seen.time,
            .distance = -seen.worst.depth,
            .pair = seen.clean() ? otherwise : describe(seen, names)};
}
}  // namespace bullet_ccd::benchmarks
