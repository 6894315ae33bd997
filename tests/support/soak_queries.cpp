#include "tests/support/soak_queries.h"

#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/support/shapes.h"
#include "tests/support/soak_families.h"

#include <algorithm>
#include <ostream>
#include <sstream>

namespace bullet_ccd::tests
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

const char* nameOf(ToiStrategy strategy)
{
    constexpr std::array<const char*, 3> kNames{"best-first", "interval", "c2a"};
    return kNames[static_cast<std::size_t>(strategy)];
}

const char* nameOf(ToiStatus status)
{
    constexpr std::array<const char*, 6> kNames{"separated",
                                                "hit",
                                                "overlapping",
                                                "touching_leaving",
                                                "touching_pressing",
                                                "iteration_limit"};
    return kNames[static_cast<std::size_t>(status)];
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

namespace
{
void printMesh(std::ostream& out, const char* name, const TriangleMesh& mesh)
{
    out << name << ": " << mesh.vertices.size() << " vertices, " << mesh.triangles.size()
        << " triangles\n";
    for (const Eigen::Vector3d& v : mesh.vertices)
    {
        out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    }
    for (const Triangle& t : mesh.triangles)
    {
        out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
}

void printMotion(std::ostream& out, const char* name, const RigidMotion& motion)
{
    const Eigen::IOFormat rows(Eigen::FullPrecision, Eigen::DontAlignCols, ", ", "; ");
    out << name << ": pose " << motion.X_W0.matrix().topRows<3>().format(rows) << "\n  v "
        << motion.v_W.transpose() << "  w " << motion.w_W.transpose() << "  reference "
        << motion.reference_B.transpose() << '\n';
}
}  // namespace

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

void SoakTally::add(const SoakOutcome& outcome)
{
    ++queries;
    const ToiStatus status = outcome.result.status;
    hits += status == ToiStatus::Hit || status == ToiStatus::TouchingPressing ? 1 : 0;
    overlapping += status == ToiStatus::Overlapping ? 1 : 0;
    free += status == ToiStatus::Separated || status == ToiStatus::TouchingLeaving ? 1 : 0;
    ++verdicts[static_cast<std::size_t>(outcome.judgement.verdict)];
}

void SoakTally::add(const SoakTally& other)
{
    queries += other.queries;
    hits += other.hits;
    overlapping += other.overlapping;
    free += other.free;
    for (std::size_t i = 0; i < verdicts.size(); ++i)
    {
        verdicts[i] += other.verdicts[i];
    }
}

std::int64_t SoakTally::wrong() const
{
    return queries - undecided() - verdicts[static_cast<std::size_t>(Verdict::Right)];
}

std::int64_t SoakTally::undecided() const
{
    return verdicts[static_cast<std::size_t>(Verdict::Undecided)];
}

std::string vacuity(const SoakTallies& tallies)
{
    constexpr std::int64_t kEnough = 200;
    std::ostringstream complaints;
    for (std::size_t i = 0; i < kSoakFamilies; ++i)
    {
        const SoakTally& tally = tallies[i];
        if (tally.queries < kEnough)
        {
            continue;
        }
        const auto percent = [&](std::int64_t part) { return 100 * part / tally.queries; };
        if (percent(tally.hits) < 10 || percent(tally.free) < 5 || percent(tally.overlapping) > 50)
        {
            complaints << nameOf(static_cast<SoakFamily>(i)) << ": " << percent(tally.hits)
                       << " % hits, " << percent(tally.free) << " % free, "
                       << percent(tally.overlapping) << " % overlapping at the start\n";
        }
        if (1000 * tally.undecided() > tally.queries)
        {
            complaints << nameOf(static_cast<SoakFamily>(i)) << ": " << tally.undecided() << " of "
                       << tally.queries << " undecided\n";
        }
    }
    return complaints.str();
}
}  // namespace bullet_ccd::tests
