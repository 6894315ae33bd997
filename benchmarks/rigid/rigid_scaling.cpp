#include "benchmarks/rigid/rigid_scaling.h"

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
constexpr double kQuickTriangles = 3e4;

/// One size of a family.
struct Size
{
    double triangles = 0.0;
    double micros = 0.0;
    double fclMicros = 0.0;
    double buildMillis = 0.0;
    double fclBuildMillis = 0.0;
    double bytes = 0.0;     ///< a triangle: nodes, triangles in their order, mesh
    double fclBytes = 0.0;  ///< a triangle: nodes and mesh
    double nodeBytes = 0.0;
    int hits = 0;
};

double bytesOf(const SsvTree& tree)
{
    const TriangleMesh& mesh = tree.mesh();
    const std::size_t perTriangle =
        sizeof(std::array<Eigen::Vector3d, 3>) + sizeof(std::int32_t) + sizeof(Triangle);
    return static_cast<double>(tree.nodes().size_bytes() + perTriangle * mesh.triangles.size() +
                               sizeof(Eigen::Vector3d) * mesh.vertices.size());
}

void measureOurs(const RigidSet& set, const ScalingOptions& options, Size& size)
{
    std::optional<SsvTree> tree;
    size.buildMillis = 1e-3 * wallMicrosecondsOf([&] { tree = buildSsvTree(*set.meshA); });
    size.bytes = bytesOf(*tree) / size.triangles;
    size.nodeBytes = static_cast<double>(tree->nodes().size_bytes()) / size.triangles;
    ToiWorkspace work;
    std::vector<std::vector<double>> times(set.queries.size());
    for (int repeat = 0; repeat <= options.repeats; ++repeat)
    {
        for (std::size_t i = 0; i < set.queries.size(); ++i)
        {
            const RigidBody a{.tree = &*tree, .motion = set.queries[i].motionA};
            const RigidBody b{.tree = &*tree, .motion = set.queries[i].motionB};
            ToiResult result;
            const double micros = microsecondsOf(
                [&] {
                    result = rigidToi(
                        a, b, {.tolerance = options.tolerance, .strategy = options.strategy}, work);
                });
            if (repeat > 0)  // the first round warms the workspace
            {
                times[i].push_back(micros);
            }
            else
            {
                size.hits += isContact(result.status) ? 1 : 0;
            }
        }
    }
    size.micros = meanOfMedians(times);
}

void measurePeer(const RigidSet& set, Size& size)
{
    std::optional<FclModel> model;
    size.fclBuildMillis = 1e-3 * wallMicrosecondsOf([&] { model.emplace(*set.meshA); });
    size.fclBytes = static_cast<double>(fclBytes(*model)) / size.triangles;
    double sum = 0.0;
    for (const RigidQuery& query : set.queries)
    {
        const FclBody a{*model, query.motionA};
        const FclBody b{*model, query.motionB};
        sum += microsecondsOf([&] { keep(fclNaive(a, b, kNaiveSamples).time); });
    }
    size.fclMicros = sum / static_cast<double>(set.queries.size());
}

/// Microseconds a doubling of the triangles adds from one size to another.
double slopeOf(const Size& smaller, const Size& larger)
{
    const double doublings = std::log2(larger.triangles / smaller.triangles);
    return doublings > 0.0 ? (larger.micros - smaller.micros) / doublings : 0.0;
}

void printSize(const std::string& set, const Size& size, const Size& smallest, const Size& before)
{
    // Logarithmic growth: the same microseconds a doubling at all sizes.
    fmt::print(
        "{:<13}{:>9.0f}{:>6}{:>9.1f}{:>9.2f}{:>12.1f}{:>10.1f}{:>9.0f}{:>9.0f}{:>9.0f}{:>9.0f}"
        "{:>9.0f}\n",
        set,
        size.triangles,
        size.hits,
        size.micros,
        size.micros / smallest.micros,
        slopeOf(before, size),
        size.fclMicros,
        size.nodeBytes,
        size.bytes,
        size.fclBytes,
        size.buildMillis,
        size.fclBuildMillis);
    std::fflush(stdout);
}
nlohmann::json toJson(const std::string& set, const Size& size)
{
    return {{"set", set},
            {"triangles", size.triangles},
            {"hits", size.hits},
            {"microseconds", size.micros},
            {"fclMicroseconds", size.fclMicros},
            {"nodeBytesPerTriangle", size.nodeBytes},
            {"bytesPerTriangle", size.bytes},
            {"fclBytesPerTriangle", size.fclBytes},
            {"buildMilliseconds", size.buildMillis},
            {"fclBuildMilliseconds", size.fclBuildMillis}};
}
}  // namespace

nlohmann::json printScaling(MeshLibrary& meshes, const ScalingOptions& options)
{
    nlohmann::json rows = nlohmann::json::array();
    fmt::print("{:<13}{:>9}{:>6}{:>9}{:>9}{:>12}{:>10}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
               "set",
               "triangles",
               "hits",
               "us",
               "growth",
               "us/doubling",
               "FCL us",
               "nodes B",
               "all B",
               "FCL B",
               "build ms",
               "FCL ms");
    for (const char* family : {"knot", "sphere"})
    {
        std::optional<Size> first;
        Size before;
        for (const std::string& name : fileSetNames())
        {
            if (!name.starts_with(std::string(family) + "_"))
            {
                continue;
            }
            const RigidSet set = makeRigidSet(name, meshes);
            Size size{.triangles = static_cast<double>(set.meshA->triangles.size())};
            if (options.quick && size.triangles > kQuickTriangles)
            {
                break;
            }
            measureOurs(set, options, size);
            if (isFclPresent())
            {
                measurePeer(set, size);
            }
            if (!first)
            {
                first = size;
                before = size;
            }
            printSize(name, size, *first, before);
            before = size;
            rows.push_back(toJson(name, size));
        }
        fmt::print("{}: {:+.2f} us a doubling from the smallest to the largest\n",
                   family,
                   first ? slopeOf(*first, before) : 0.0);
    }
    fmt::print(
        "growth: time against the smallest size; us/doubling: against the size before, constant "
        "where time grows with the logarithm.\n"
        "Bytes a triangle: our nodes; all of our hierarchy, with its "
        "copy of the mesh; FCL's nodes and mesh.\n");
    return rows;
}
}  // namespace bullet_ccd::benchmarks
