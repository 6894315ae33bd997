#include "benchmarks/reference/queries/chain_queries.h"

#include "benchmarks/reference/oracles/articulated_judge.h"
#include "benchmarks/reference/queries/chain_families.h"
#include "benchmarks/reference/scenes/print_scene.h"
#include "benchmarks/reference/scenes/random.h"

#include <array>
#include <ostream>
#include <sstream>

namespace bullet_ccd::reference
{
namespace
{
constexpr std::uint64_t kJointCounts = kMostJoints - kFewestJoints + 1;

/// Ways of searching that give the same answers.
const std::array<ArticulatedToiOptions, 4>& waysOfSearching()
{
    static const std::array<ArticulatedToiOptions, 4> kWays{
        {{},
         {.toi = {}, .cullBySpace = false, .cullByTime = false, .subdivide = false},
         {.toi = {.strategy = ToiStrategy::Interval}},
         {.toi = {}, .subdivide = false}}};
    return kWays;
}
static_assert(kChainRound == kChainFamilies * kJointCounts);
}  // namespace

const char* nameOf(ChainFamily family)
{
    constexpr std::array<const char*, kChainFamilies> kNames{"revolute",
                                                             "prismatic",
                                                             "spherical",
                                                             "mixed",
                                                             "floating-base",
                                                             "mimic",
                                                             "self-collision",
                                                             "fingers"};
    return kNames[static_cast<std::size_t>(family)];
}

std::vector<std::string> chainFamilyNames()
{
    std::vector<std::string> names;
    for (std::size_t i = 0; i < kChainFamilies; ++i)
    {
        names.emplace_back(nameOf(static_cast<ChainFamily>(i)));
    }
    return names;
}

ChainQuery chainQuery(std::uint64_t seed)
{
    Random random(seed * 0x9E3779B97F4A7C15ULL + 7);
    const std::uint64_t joints = seed / kChainFamilies % kJointCounts;
    const std::uint64_t way = seed / kChainRound % waysOfSearching().size();
    ChainQuery query{.family = static_cast<ChainFamily>(seed % kChainFamilies),
                     .options = waysOfSearching()[way]};
    query.scene = chainScene(query.family, kFewestJoints + static_cast<int>(joints), random);
    query.options.toi.tolerance = random.logUniform(1e-7, 1e-3);
    return query;
}

namespace
{
void printLink(std::ostream& out, const ChainQuery& query, std::size_t index)
{
    constexpr std::array<const char*, 4> kTypes{"fixed", "revolute", "prismatic", "spherical"};
    const Eigen::IOFormat rows(Eigen::FullPrecision, Eigen::DontAlignCols, ", ", "; ");
    const Link& link = query.scene.tree.links[index];
    const JointMotion& motion = query.scene.motion;
    out << "link " << index << ": parent " << link.parent << ", "
        << kTypes[static_cast<std::size_t>(link.joint.type)] << " about "
        << link.joint.axis.transpose() << ", position " << motion.positions[index] << ", rate "
        << motion.rates[index] << "\n  place " << link.X_PL0.matrix().topRows<3>().format(rows)
        << '\n';
    if (link.joint.type == JointType::Spherical)
    {
        const BallMotion& ball = motion.balls[index];
        out << "  ball from " << ball.start.format(rows) << " at " << ball.rate.transpose() << '\n';
    }
    if (link.joint.mimicOf != kNone)
    {
        out << "  follows joint " << link.joint.mimicOf << '\n';
    }
    printMesh(out, "mesh", query.scene.linkMeshes[index]);
}
}  // namespace

void print(std::ostream& out, const ChainQuery& query)
{
    const ArticulatedScene& scene = query.scene;
    std::ostringstream text;
    text.precision(17);
    text << "family " << nameOf(query.family) << ", " << scene.tree.size() - 1
         << " joints, tolerance " << query.options.toi.tolerance << ", "
         << (query.options.toi.strategy == ToiStrategy::Interval ? "interval" : "best-first")
         << (query.options.cullBySpace ? "" : ", not culled")
         << (query.options.subdivide ? "" : ", not subdivided") << '\n';
    printMotion(text, "root", scene.motion.root);
    for (std::size_t i = 0; i < scene.tree.size(); ++i)
    {
        printLink(text, query, i);
    }
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    {
        const std::string name = "obstacle " + std::to_string(i);
        printMotion(text, name, scene.obstacleMotions[i]);
        printMesh(text, name, scene.obstacles[i]);
    }
    text << "pairs of links:";
    for (const auto& [first, second] : scene.selfPairs)
    {
        text << ' ' << first << '-' << second;
    }
    out << text.str() << '\n';
}

ChainOutcome runChainQuery(const ChainQuery& query)
{
    thread_local ToiWorkspace work;
    const BuiltScene built(query.scene);
    ChainOutcome outcome{.result = articulatedToi(
                             built.body(), Environment(built.obstacles()), query.options, work)};
    outcome.judgement = judgeArticulated(query.scene, query.options.toi, outcome.result);
    return outcome;
}
}  // namespace bullet_ccd::reference
