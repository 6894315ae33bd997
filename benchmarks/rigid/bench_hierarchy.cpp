// Kinds of bounding volumes and sizes of meshes: what the hierarchy costs and what it saves.
//
//   bench_hierarchy [--data FOLDER] [--repeat N]   every kind: rigidToi on several sets of queries
//   bench_hierarchy --scaling                      bytes and times for 1K to 1M triangles
//
// Times of --scaling are medians; (1) is one thread, (all) every core; refit, save and load are
// those of the default kind, with the file in the system's cache.
//
// FOLDER (default: $BULLET_CCD_TEST_DATA) may hold rigid_queries/poses/bunny_ident.csv and the
// bunny; without them the generated sets remain. Every query starts cold; times are the mean over a
// set of the median over the repeats. All kinds must agree on hits, or the program fails.
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/hierarchy/ssv_tree_file.h"
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <oneapi/tbb/global_control.h>
#include <optional>
#include <random>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr std::pair<SsvKind, const char*> kKinds[] = {
    {SsvKind::Box, "box"},
    {SsvKind::RoundedBox, "rounded box"},
    {SsvKind::SweptRectangle, "swept rectangle"},
    {SsvKind::SweptLine, "swept line"},
    {SsvKind::SweptPoint, "swept point"},
    {SsvKind::Cheapest, "cheapest"},
};

double secondsOf(const std::function<void()>& work)
{
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double medianSecondsOf(int repeats, const std::function<void()>& work)
{
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i)
    {
        seconds.push_back(secondsOf(work));
    }
    std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
    return seconds[static_cast<std::size_t>(repeats / 2)];
}

/// Two bodies with the same mesh and many motions of both.
struct QuerySet
{
    std::string name;
    TriangleMesh mesh;
    std::vector<std::pair<RigidMotion, RigidMotion>> motions;
    double tolerance = 1e-4;
};

class Random
{
public:
    double uniform(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(m_engine);
    }
    Vector3d direction()
    {
        std::normal_distribution<double> gauss;
        return Vector3d(gauss(m_engine), gauss(m_engine), gauss(m_engine)).normalized();
    }
    Eigen::Matrix3d rotation()
    {
        return Eigen::AngleAxisd(uniform(-3.0, 3.0), direction()).toRotationMatrix();
    }

private:
    std::mt19937_64 m_engine{7};
};

/// A tube of radius 0.012 m along a (2, 3) torus knot of radius 0.05 to 0.11 m.
TriangleMesh makeKnot(int along, int around)
{
    TriangleMesh mesh;
    const auto curve = [](double s)
    {
        const double r = 0.08 + 0.03 * std::cos(3.0 * s);
        return Vector3d(r * std::cos(2.0 * s), r * std::sin(2.0 * s), 0.04 * std::sin(3.0 * s));
    };
    for (int i = 0; i < along; ++i)
    {
        const double s = 2.0 * std::numbers::pi * i / along;
        const Vector3d tangent = (curve(s + 1e-4) - curve(s - 1e-4)).normalized();
        const Vector3d side = tangent.cross(Vector3d::UnitZ()).normalized();
        const Vector3d up = side.cross(tangent);
        for (int k = 0; k < around; ++k)
        {
            const double phi = 2.0 * std::numbers::pi * k / around;
            mesh.vertices.push_back(curve(s) + 0.012 * (std::cos(phi) * side + std::sin(phi) * up));
            const int i1 = (i + 1) % along;
            const int k1 = (k + 1) % around;
            mesh.triangles.push_back({i * around + k, i1 * around + k, i1 * around + k1});
            mesh.triangles.push_back({i * around + k, i1 * around + k1, i * around + k1});
        }
    }
    return mesh;
}

/// Motions that start on a sphere around B and pass by or through it, turning by up to 2 rad.
QuerySet passing(const std::string& name, TriangleMesh mesh)
{
    QuerySet set{.name = name, .mesh = std::move(mesh), .motions = {}};
    const double size = bounds(set.mesh).diagonal().norm();
    set.tolerance = 1e-6 * size;
    Random random;
    for (int i = 0; i < 200; ++i)
    {
        const Vector3d from = random.direction();
        RigidMotion a;
        a.X_W0.linear() = random.rotation();
        a.X_W0.translation() = 1.1 * size * from;
        a.v_W = size * (-1.5 * from + 0.8 * random.direction());
        a.w_W = random.uniform(0.0, 2.0) * random.direction();
        set.motions.emplace_back(a, RigidMotion{});
    }
    return set;
}

/// From the hits of a set: start a small gap before contact and go on for a few gaps in any
/// direction.
QuerySet nearContact(const std::string& name, const QuerySet& far)
{
    QuerySet set{.name = name, .mesh = far.mesh, .motions = {}, .tolerance = far.tolerance};
    const SsvTree tree = buildSsvTree(set.mesh);
    const double size = bounds(set.mesh).diagonal().norm();
    ToiWorkspace work;
    Random random;
    for (const auto& [a, b] : far.motions)
    {
        const ToiResult hit = rigidToi({.tree = &tree, .motion = a},
                                       {.tree = &tree, .motion = b},
                                       {.tolerance = set.tolerance},
                                       work);
        const double gap = size * random.uniform(0.003, 0.05);
        RigidMotion start = restAt(a.at(hit.time).X_W);
        start.X_W0.translation() -= gap * a.v_W.normalized();
        if (hit.status != ToiStatus::Hit ||
            treeDistance(tree, tree, b.X_W0.inverse() * start.X_W0, size).distance <= 0.1 * gap)
        {
            continue;
        }
        start.v_W = gap * (2.0 * a.v_W.normalized() + 2.0 * random.direction());
        start.w_W = 0.1 * random.direction();
        set.motions.emplace_back(start, b);
    }
    return set;
}

Isometry3d toPose(std::span<const double> numbers)
{
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Eigen::Quaterniond(numbers[0], numbers[1], numbers[2], numbers[3])
                     .normalized()
                     .toRotationMatrix();
    X.translation() = Vector3d(numbers[4], numbers[5], numbers[6]);
    return X;
}

/// Rows of an id and four poses: A and B at the start and the end.
QuerySet readQueries(const std::string& name, const fs::path& mesh, const fs::path& poses)
{
    QuerySet set{.name = name, .mesh = loadMeshFile(mesh).mesh, .motions = {}};
    std::ifstream file(poses);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line))
    {
        std::vector<double> numbers;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');)
        {
            numbers.push_back(std::stod(cell));
        }
        if (numbers.size() != 29)
        {
            throw std::runtime_error(poses.string() + ": a row has not an id and four poses");
        }
        // Columns a0, a1, b0, b1.
        const auto pose = [&](std::size_t i)
        { return toPose(std::span(numbers).subspan(1 + 7 * i, 7)); };
        set.motions.emplace_back(motionBetween(pose(0), pose(1)), motionBetween(pose(2), pose(3)));
    }
    return set;
}

struct Measured
{
    double nodePairs = 0.0;
    double trianglePairs = 0.0;
    double microseconds = 0.0;
    int hits = 0;
};

Measured measure(const QuerySet& set, const SsvTree& tree, int repeats)
{
    Measured sum;
    ToiWorkspace work;
    for (const auto& [motionA, motionB] : set.motions)
    {
        ToiResult result;
        const double seconds = medianSecondsOf(repeats,
                                               [&]
                                               {
                                                   result =
                                                       rigidToi({.tree = &tree, .motion = motionA},
                                                                {.tree = &tree, .motion = motionB},
                                                                {.tolerance = set.tolerance},
                                                                work);
                                               });
        sum.nodePairs += static_cast<double>(result.counters.nodePairs);
        sum.trianglePairs += static_cast<double>(result.counters.trianglePairs);
        sum.microseconds += 1e6 * seconds;
        sum.hits += isContact(result.status) ? 1 : 0;
    }
    const auto count = static_cast<double>(set.motions.size());
    return {.nodePairs = sum.nodePairs / count,
            .trianglePairs = sum.trianglePairs / count,
            .microseconds = sum.microseconds / count,
            .hits = sum.hits};
}

double bytesOf(const SsvTree& tree)
{
    const double triangles = static_cast<double>(tree.mesh().triangles.size());
    const double mesh = static_cast<double>(tree.mesh().vertices.size() * sizeof(Vector3d) +
                                            tree.mesh().triangles.size() * sizeof(Triangle));
    const double nodes = static_cast<double>(tree.nodes().size() * sizeof(SsvNode));
    return mesh + nodes + triangles * (sizeof(std::array<Vector3d, 3>) + sizeof(std::int32_t));
}

void compareKinds(const std::optional<fs::path>& data, int repeats)
{
    std::vector<QuerySet> sets;
    if (data)
    {
        sets.push_back(readQueries("bunny 70K, ident",
                                   *data / "motions/c2a_torusknot/bunny_noholes.ply",
                                   *data / "rigid_queries/poses/bunny_ident.csv"));
        sets.push_back(nearContact("bunny 70K, near contact", sets.front()));
    }
    sets.push_back(passing("knot 16K", makeKnot(512, 16)));
    sets.push_back(nearContact("knot 16K, near contact", sets.back()));
    sets.push_back(passing("sphere 20K", makeSphere(0.1, 5)));
    sets.push_back(passing("torus 8K", makeTorus(0.1, 0.03, 128, 32)));
    sets.push_back(passing("cylinder 256", makeCylinder(0.02, 0.3, 64)));
    for (const QuerySet& set : sets)
    {
        std::printf("\n%s: %zu triangles, %zu queries\n",
                    set.name.c_str(),
                    set.mesh.triangles.size(),
                    set.motions.size());
        std::printf("  %-16s %9s %8s %11s %14s %10s %6s\n",
                    "kind",
                    "build ms",
                    "bytes/t",
                    "node pairs",
                    "triangle pairs",
                    "us/query",
                    "hits");
        int hits = -1;
        for (const auto& [kind, name] : kKinds)
        {
            const SsvTree tree = buildSsvTree(set.mesh, {.kind = kind});
            const double build =
                medianSecondsOf(3, [&, k = kind] { (void)buildSsvTree(set.mesh, {.kind = k}); });
            const Measured m = measure(set, tree, repeats);
            std::printf("  %-16s %9.1f %8.0f %11.0f %14.1f %10.1f %6d\n",
                        name,
                        1e3 * build,
                        bytesOf(tree) / static_cast<double>(set.mesh.triangles.size()),
                        m.nodePairs,
                        m.trianglePairs,
                        m.microseconds,
                        m.hits);
            std::fflush(stdout);
            if (hits >= 0 && hits != m.hits)
            {
                throw std::logic_error("the kinds disagree on the number of hits");
            }
            hits = m.hits;
        }
    }
}

/// One line: a knotted tube of about `triangles` triangles.
void printScale(int triangles, const fs::path& folder)
{
    const int around = 4 << static_cast<int>(std::log2(std::sqrt(triangles / 1024.0)) + 0.5);
    const TriangleMesh mesh = makeKnot(triangles / (2 * around), around);
    const int repeats = triangles > 100'000 ? 3 : 9;
    const auto milliseconds = [&](const auto& work)
    { return 1e3 * medianSecondsOf(repeats, work); };
    const auto build = [&] { (void)buildSsvTree(mesh); };

    double oneThread = 0.0;
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        oneThread = milliseconds(build);
    }
    const double allThreads = milliseconds(build);
    SsvTree tree = buildSsvTree(mesh);
    const double refit = milliseconds([&] { tree.refit(mesh.vertices); });
    const fs::path file = folder / ssvTreeFileName(mesh, tree.options());
    const double save = milliseconds([&] { saveSsvTree(tree, file); });
    const double load = milliseconds([&] { (void)loadSsvTree(mesh, tree.options(), file); });
    const auto count = static_cast<double>(mesh.triangles.size());
    std::printf("%9.0f %12.1f %10.1f %14.2f %14.2f %9.2f %9.2f %9.2f\n",
                count,
                static_cast<double>(tree.nodes().size_bytes()) / count,
                bytesOf(tree) / count,
                oneThread,
                allThreads,
                refit,
                save,
                load);
    std::fflush(stdout);
}

void printScaling()
{
    std::printf("%9s %12s %10s %14s %14s %9s %9s %9s\n",
                "triangles",
                "node bytes/t",
                "bytes/t",
                "build ms (1)",
                "build ms (all)",
                "refit ms",
                "save ms",
                "load ms");
    const fs::path folder =
        fs::temp_directory_path() / ("bench_hierarchy_" + std::to_string(std::random_device()()));
    fs::create_directories(folder);
    for (int triangles = 1 << 10; triangles <= 1 << 20; triangles *= 4)
    {
        printScale(triangles, folder);
    }
    fs::remove_all(folder);
}
}  // namespace

int main(int argc, char** argv)
{
    try
    {
        const char* folder = std::getenv("BULLET_CCD_TEST_DATA");
        std::optional<fs::path> data;
        if (folder != nullptr)
        {
            data = folder;
        }
        int repeats = 5;
        bool scaling = false;
        for (int i = 1; i < argc; ++i)
        {
            const std::string argument = argv[i];
            if (argument == "--data" && i + 1 < argc)
            {
                data = argv[++i];
            }
            else if (argument == "--repeat" && i + 1 < argc)
            {
                repeats = std::max(std::stoi(argv[++i]), 1);
            }
            else if (argument == "--scaling")
            {
                scaling = true;
            }
            else
            {
                std::fprintf(stderr,
                             "usage: bench_hierarchy [--data FOLDER] [--repeat N] | --scaling\n");
                return 2;
            }
        }
        if (scaling)
        {
            printScaling();
        }
        else
        {
            compareKinds(data, repeats);
        }
        return 0;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "bench_hierarchy: %s\n", error.what());
        return 1;
    }
}
