#include "benchmarks/rigid/rigid_growth.h"

#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <random>

namespace bullet_ccd::benchmarks
{
namespace
{
namespace fs = std::filesystem;

constexpr std::size_t kQuickTriangles = 30'000;
constexpr std::size_t kLargeMesh = 300'000;  ///< built once, smaller ones three times

template <typename Work>
double milliseconds(const TriangleMesh& mesh, const Work& work)
{
    std::vector<double> times;
    const std::size_t repeats = mesh.triangles.size() > kLargeMesh ? 1 : 3;
    while (times.size() < repeats)
    {
        times.push_back(1e-3 * wallMicrosecondsOf(work));
    }
    return medianOf(times);
}

/// A folder that goes with the object.
struct ScratchFolder
{
    ScratchFolder() { fs::create_directories(path); }
    ~ScratchFolder() { fs::remove_all(path); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    fs::path path =
        fs::temp_directory_path() / fmt::format("bench_rigid_{}", std::random_device()());
};

/// Bytes a triangle, times of building, refitting, saving and loading, ours and the peer's.
void addHierarchy(const TriangleMesh& mesh, const RunOptions& options, nlohmann::json& row)
{
    const auto count = static_cast<double>(mesh.triangles.size());
    row["triangles"] = mesh.triangles.size();
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        row["buildMillisecondsAlone"] = buildMilliseconds(mesh, VolumeKind::RoundedBox);
    }
    row["buildMilliseconds"] = buildMilliseconds(mesh, VolumeKind::RoundedBox);
    SsvTree tree = buildSsvTree(mesh);
    row["nodeBytesPerTriangle"] = static_cast<double>(tree.nodes().size_bytes()) / count;
    row["bytesPerTriangle"] = bytesOf(tree) / count;
    row["refitMilliseconds"] = milliseconds(mesh, [&] { tree.refit(mesh.vertices); });
    const ScratchFolder folder;
    const fs::path file = folder.path / ssvTreeFileName(mesh);
    row["saveMilliseconds"] = milliseconds(mesh, [&] { saveSsvTree(tree, file); });
    row["loadMilliseconds"] = milliseconds(mesh, [&] { (void)loadSsvTree(mesh, file); });
    if (options.fcl && isFclPresent())
    {
        std::optional<FclModel> model;
        row["fclBuildMilliseconds"] = milliseconds(mesh, [&] { model.emplace(mesh); });
        row["fclBytesPerTriangle"] = static_cast<double>(fclBytes(*model)) / count;
    }
}

/// Microseconds a doubling of the triangles adds from one size to another.
double slopeOf(const nlohmann::json& smaller, const nlohmann::json& larger)
{
    const auto of = [](const nlohmann::json& row, const char* key)
    { return row[key].get<double>(); };
    const double doublings = std::log2(of(larger, "triangles") / of(smaller, "triangles"));
    return doublings > 0.0 ? (of(larger, "microseconds") - of(smaller, "microseconds")) / doublings
                           : 0.0;
}

nlohmann::json rowOf(const RigidSet& set, const RunOptions& options)
{
    Hierarchies hierarchies;  // not kept: the largest take 200 MB each
    NaiveCache cache("");
    const RigidRow run = runTogether(std::span(&set, 1), options, hierarchies, cache).at(0);
    nlohmann::json row = run.values;
    row["wrong"] = run.check.wrong();
    addHierarchy(*set.meshA, options, row);
    return row;
}
}  // namespace

double bytesOf(const SsvTree& tree)
{
    const TriangleMesh& mesh = tree.mesh();
    const std::size_t perTriangle =
        sizeof(std::array<Eigen::Vector3d, 3>) + sizeof(std::int32_t) + sizeof(Triangle);
    return static_cast<double>(tree.nodes().size_bytes() + perTriangle * mesh.triangles.size() +
                               sizeof(Eigen::Vector3d) * mesh.vertices.size());
}

double buildMilliseconds(const TriangleMesh& mesh, VolumeKind kind)
{
    return milliseconds(mesh, [&] { (void)buildTreeOf(kind, mesh); });
}

nlohmann::json printGrowth(MeshLibrary& meshes, const RunOptions& options, bool isQuick)
{
    const Table table(
        "set:<12|triangles:>9|hits=contacts:>5|wrong:>5|us=microseconds:>8.1f|growth:>6.2f|"
        "us/doubling=usPerDoubling:>11.1f|FCL us=fclMicroseconds:>9.1f|"
        "nodes B=nodeBytesPerTriangle:>7.0f|all B=bytesPerTriangle:>6.0f|"
        "FCL B=fclBytesPerTriangle:>6.0f|build ms (1)=buildMillisecondsAlone:>12.1f|"
        "build ms=buildMilliseconds:>8.1f|FCL ms=fclBuildMilliseconds:>8.1f|"
        "refit ms=refitMilliseconds:>8.2f|save ms=saveMilliseconds:>8.2f|"
        "load ms=loadMilliseconds:>8.2f");
    nlohmann::json rows = nlohmann::json::array();
    for (const std::string family : {"knot_", "sphere_"})
    {
        nlohmann::json first;
        nlohmann::json before;
        for (const std::string& name : fileSetNames())
        {
            if (!name.starts_with(family) ||
                (isQuick && meshes.mesh(name)->triangles.size() > kQuickTriangles))
            {
                continue;
            }
            nlohmann::json row = rowOf(makeRigidSet(name, meshes), options);
            first = first.is_null() ? row : first;
            before = before.is_null() ? row : before;
            row["growth"] = row["microseconds"].get<double>() / first["microseconds"].get<double>();
            row["usPerDoubling"] = slopeOf(before, row);
            table.print(row);
            before = row;
            rows.push_back(std::move(row));
        }
        fmt::print("{}: {:+.2f} us a doubling from the smallest to the largest\n",
                   family,
                   first.is_null() ? 0.0 : slopeOf(first, before));
    }
    fmt::print(
        "growth: time against the smallest size; us/doubling: against the size before, constant "
        "where time grows with the logarithm.\nBytes per triangle: our nodes; all of our "
        "hierarchy, with its copy of the mesh; FCL's nodes and mesh.\nbuild (1): on one thread; "
        "refit, save and load: of our hierarchy, with the file in the system's cache.\n");
    return rows;
}
}  // namespace bullet_ccd::benchmarks
