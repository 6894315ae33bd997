#include "benchmarks/reference/queries/soak_queries.h"

#include "benchmarks/reference/queries/soak_families.h"
#include "benchmarks/reference/scenes/print_scene.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <array>
#include <ostream>
#include <sstream>

namespace bullet_ccd::reference
{
namespace
{
/// Any tolerance, or one near the gap that the scene was made for; never below what rounding
/// leaves.
double chooseTolerance(Random& random, const SoakScene& made)
{
    double tolerance = made.tolerance;
    if (tolerance == 0.0)
    {
        const bool nearClearance = made.clearance < 1.0 && random.chance(0.3);
        tolerance = nearClearance ? made.clearance * random.logUniform(0.1, 10.0)
                                  : random.logUniform(1e-9, 1e-2);
    }
    return tolerance * made.scale;
}
}  // namespace

const char* nameOf(SoakFamily family)
{
    constexpr std::array<const char*, kSoakFamilies> kNames{"soups",
                                                            "slivers",
                                                            "degenerate",
                                                            "coplanar-faces",
                                                            "parallel-edges",
                                                            "thin-plates",
                                                            "spikes",
                                                            "grazing",
                                                            "near-miss",
                                                            "multi-turn",
                                                            "both-turning",
                                                            "co-moving",
                                                            "far-small",
                                                            "scales",
                                                            "start-touching",
                                                            "clearance"};
    return kNames[static_cast<std::size_t>(family)];
}

std::vector<std::string> soakFamilyNames()
{
    std::vector<std::string> names;
    for (std::size_t i = 0; i < kSoakFamilies; ++i)
    {
        names.emplace_back(nameOf(static_cast<SoakFamily>(i)));
    }
    return names;
}

const char* nameOf(ToiStrategy strategy)
{
    constexpr std::array<const char*, 3> kNames{"best-first", "interval", "c2a"};
    return kNames[static_cast<std::size_t>(strategy)];
}

SoakQuery soakQuery(std::uint64_t seed)
{
    Random random(seed * 0x9E3779B97F4A7C15ULL + 1);
    SoakQuery query;
    query.family = static_cast<SoakFamily>(seed % kSoakFamilies);
    query.options.strategy = static_cast<ToiStrategy>(seed / kSoakFamilies % 3);
    SoakScene made = soakScene(query.family, random);
    if (random.chance(0.5))
    {
        made.scene = moved(made.scene, random.pose(5.0));
    }
    if (random.chance(0.3))
    {
        made.scene = swapped(made.scene);
    }
    query.scene = made.scale == 1.0 ? made.scene : scaled(made.scene, made.scale);
    query.options.tolerance =
        std::max(chooseTolerance(random, made), 4.0 * distanceRounding(query.scene));
    query.options.minimumSeparation = made.separation * made.scale;
    if (random.chance(0.05))
    {
        // What is said at an early end must hold, too.
        query.options.maxIterations = static_cast<std::int64_t>(random.logUniform(1.0, 1e3));
    }
    return query;
}

void print(std::ostream& out, const SoakQuery& query)
{
    std::ostringstream text;
    text.precision(17);
    text << "family " << nameOf(query.family) << ", strategy " << nameOf(query.options.strategy)
         << ", tolerance " << query.options.tolerance << ", minimum separation "
         << query.options.minimumSeparation << ", at most " << query.options.maxIterations
         << " iterations\n";
    printMotion(text, "motion A", query.scene.motionA);
    printMotion(text, "motion B", query.scene.motionB);
    printMesh(text, "mesh A", query.scene.meshA);
    printMesh(text, "mesh B", query.scene.meshB);
    out << text.str();
}

SoakOutcome runSoakQuery(const SoakQuery& query)
{
    thread_local ToiWorkspace work;
    const SsvTree treeA = buildSsvTree(query.scene.meshA);
    const SsvTree treeB = buildSsvTree(query.scene.meshB);
    SoakOutcome outcome{.result = rigidToi({.tree = &treeA, .motion = query.scene.motionA},
                                           {.tree = &treeB, .motion = query.scene.motionB},
                                           query.options,
                                           work)};
    outcome.judgement = judgeToi(query.scene, query.options, outcome.result);
    return outcome;
}
}  // namespace bullet_ccd::reference
