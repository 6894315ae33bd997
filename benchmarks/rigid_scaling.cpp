#include "benchmarks/rigid_scaling.h"

#include "benchmarks/fcl_peer.h"
#include "benchmarks/rigid_targets.h"
#include "benchmarks/timing.h"
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
    double bytes = 0.0;     ///< a triangle: nodes and the triangles in their order
    double fclBytes = 0.0;  ///< a triangle: nodes and mesh
    double nodeBytes = 0.0;
    int hits = 0;
};

double bytesOf(const SsvTree& tree)
{
    const std::size_t perTriangle = sizeof(std::array<Eigen::Vector3d, 3>) + sizeof(std::int32_t);
    return static_cast<double>(tree.nodes().size_bytes() +
                               perTriangle * tree.mesh().triangles.size());
}

void measureOurs(const RigidSet& set, const ScalingOptions& options, Size& size)
{
    std::optional<SsvTree> tree;
    size.buildMillis = 1e-3 * microsecondsOf([&] { tree = buildSsvTree(*set.meshA); });
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
    size.fclBuildMillis = 1e-3 * microsecondsOf([&] { model.emplace(*set.meshA); });
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

void printSize(const std::string& set, const Size& size, double baseMicros, double baseTriangles)
{
    // Logarithmic growth: time / log2(triangles) does not grow.
    const double logs = std::log2(size.triangles) / std::log2(baseTriangles);
    fmt::print(
        "{:<13}{:>9.0f}{:>6}{:>9.1f}{:>9.2f}{:>9.2f}{:>10.1f}{:>9.0f}{:>9.0f}{:>9.0f}{:>9.0f}"
        "{:>9.0f}\n",
        set,
        size.triangles,
        size.hits,
        size.micros,
        size.micros / baseMicros,
        logs,
        size.fclMicros,
        size.nodeBytes,
        size.bytes,
        size.fclBytes,
        size.buildMillis,
        size.fclBuildMillis);
    std::fflush(stdout);
}
}  // namespace

nlohmann::json printScaling(MeshLibrary& meshes, const ScalingOptions& options)
{
    nlohmann::json rows = nlohmann::json::array();
    fmt::print("{:<13}{:>9}{:>6}{:>9}{:>9}{:>9}{:>10}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
               "set",
               "triangles",
               "hits",
               "us",
               "growth",
               "log grow",
               "FCL us",
               "nodes B",
               "all B",
               "FCL B",
               "build ms",
               "FCL ms");
    for (const char* family : {"knot", "sphere"})
    {
        std::optional<Size> first;
        double slope = 0.0;
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
            first = first.value_or(size);
            const double doublings = std::log2(size.triangles / first->triangles);
            slope = doublings > 0.0 ? (size.micros - first->micros) / doublings : 0.0;
            printSize(name, size, first->micros, first->triangles);
            rows.push_back({{"set", name},
                            {"triangles", size.triangles},
                            {"hits", size.hits},
                            {"microseconds", size.micros},
                            {"fclMicroseconds", size.fclMicros},
                            {"nodeBytesPerTriangle", size.nodeBytes},
                            {"bytesPerTriangle", size.bytes},
                            {"fclBytesPerTriangle", size.fclBytes},
                            {"buildMilliseconds", size.buildMillis},
                            {"fclBuildMilliseconds", size.fclBuildMillis}});
        }
        fmt::print("{}: {:+.2f} us a doubling of the triangles\n", family, slope);
    }
    fmt::print(
        "growth: time against the smallest size; log grow: what time ~ log(triangles) would "
        "give.\nBytes a triangle: our nodes; with our triangles; FCL's nodes and mesh.\n");
    return rows;
}
}  // namespace bullet_ccd::benchmarks
