#include "benchmarks/reference/scenes/deforming_scenes.h"

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace bullet_ccd::reference
{
namespace
{
/// A shard of a mesh, apart from the others by vertices of its own.
struct Shard
{
    std::vector<std::int32_t> vertices;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

std::vector<Eigen::Vector3d> shardSeeds(const TriangleMesh& whole, int triangles, Random& random)
{
    std::vector<Eigen::Vector3d> seeds;
    const int last = static_cast<int>(whole.vertices.size()) - 1;
    for (int i = 0; i < std::max(2, triangles / 500); ++i)
    {
        seeds.push_back(whole.vertices[static_cast<std::size_t>(random.integer(0, last))]);
    }
    return seeds;
}

std::vector<Shard> breakMesh(const TriangleMesh& whole,
                             const std::vector<Eigen::Vector3d>& seeds,
                             TriangleMesh& mesh)
{
    std::vector<Shard> shards(seeds.size());
    std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>> made(whole.vertices.size());
    for (const Triangle& t : whole.triangles)
    {
        const Eigen::Vector3d& x = whole.vertices[static_cast<std::size_t>(t[0])];
        const auto nearest = std::ranges::min_element(
            seeds, {}, [&](const Eigen::Vector3d& seed) { return (seed - x).squaredNorm(); });
        const auto index = static_cast<std::int32_t>(nearest - seeds.begin());
        Shard& shard = shards[static_cast<std::size_t>(index)];
        Triangle copy{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto v = static_cast<std::size_t>(t[k]);
            const auto known =
                std::ranges::find(made[v], index, &std::pair<std::int32_t, std::int32_t>::first);
            if (known != made[v].end())
            {
                copy[k] = known->second;
                continue;
            }
            copy[k] = static_cast<std::int32_t>(mesh.vertices.size());
            made[v].emplace_back(index, copy[k]);
            shard.vertices.push_back(copy[k]);
            shard.centre += whole.vertices[v];
            mesh.vertices.push_back(whole.vertices[v]);
        }
        mesh.triangles.push_back(copy);
    }
    for (Shard& shard : shards)
    {
        shard.centre /= std::max<double>(1.0, static_cast<double>(shard.vertices.size()));
        for (const std::int32_t v : shard.vertices)  // a little smaller, so that none touch yet
        {
            Eigen::Vector3d& x = mesh.vertices[static_cast<std::size_t>(v)];
            x = shard.centre + 0.98 * (x - shard.centre);
        }
    }
    return shards;
}

DeformingScene makeBreaking(int triangles, int steps)
{
    Random random(7);
    const int minor = std::max(8, static_cast<int>(std::sqrt(triangles / 6.0)));
    const TriangleMesh whole = makeTorus(1.0, 0.35, std::max(8, triangles / (2 * minor)), minor);
    DeformingScene scene;
    const std::vector<Shard> shards =
        breakMesh(whole, shardSeeds(whole, triangles, random), scene.mesh);
    const double size = 3.0 / std::sqrt(static_cast<double>(shards.size()));
    scene.frames.push_back(scene.mesh.vertices);
    for (int step = 0; step < steps; ++step)
    {
        scene.frames.push_back(scene.frames.back());
    }
    for (const Shard& shard : shards)
    {
        const Eigen::Vector3d move = 0.15 * size * random.direction();
        const Eigen::Vector3d axis = random.direction();
        const double turn = random.uniform(0.0, 0.15);
        for (int step = 1; step <= steps; ++step)
        {
            const Eigen::Matrix3d R = Eigen::AngleAxisd(step * turn, axis).toRotationMatrix();
            for (const std::int32_t v : shard.vertices)
            {
                const auto i = static_cast<std::size_t>(v);
                scene.frames[static_cast<std::size_t>(step)][i] =
                    shard.centre + step * move + R * (scene.mesh.vertices[i] - shard.centre);
            }
        }
    }
    return scene;
}

/// A square of edge 2 about the origin; `height` says where its vertices are.
TriangleMesh makeSheet(int triangles, const std::function<double(double, double)>& height)
{
    const int n = std::max(2, static_cast<int>(std::sqrt(triangles / 2.0)));
    TriangleMesh mesh = sheet(n);
    for (Eigen::Vector3d& v : mesh.vertices)
    {
        v.head<2>() = (2.0 * v.head<2>()).array() - 1.0;
        v.z() = height(v.x(), v.y());
    }
    return mesh;
}

DeformingScene makeFalling(int triangles, int steps)
{
    DeformingScene scene;
    int subdivisions = 1;
    while (20 * std::pow(4.0, subdivisions + 1) <= triangles / 2.0)
    {
        ++subdivisions;
    }
    scene.mesh = makeSphere(0.6, subdivisions);
    const std::size_t first = scene.mesh.vertices.size();
    appendMesh(scene.mesh,
               makeSheet(triangles * 2 / 3,
                         [](double x, double y)
                         { return 0.62 + 0.01 * std::sin(40.0 * x) * std::sin(31.0 * y); }));
    scene.frames.push_back(scene.mesh.vertices);
    for (int step = 1; step <= steps; ++step)
    {
        scene.frames.push_back(scene.frames.back());
        for (std::size_t v = first; v < scene.frames.back().size(); ++v)
        {
            Eigen::Vector3d& x = scene.frames.back()[v];
            const double radius = x.head<2>().norm();
            // Over the sphere it comes down to a little inside; beside it, it falls freely.
            const double lowest = radius < 0.55 ? std::sqrt(0.36 - radius * radius) - 0.002 : -1.0;
            x.z() = std::max(x.z() - 0.03, lowest + 0.004 * std::sin(40.0 * x.x()));
        }
    }
    return scene;
}

DeformingScene makeLayers(int triangles, int steps)
{
    constexpr int kLayers = 50;
    // The distance of the layers shrinks, and the waves of one move against those of the next.
    const auto height = [](int layer, int step, double x, double y)
    {
        const double distance = 0.02 * std::max(0.3, 1.0 - 0.1 * step);
        const double phase = layer + (layer % 2 == 0 ? 0.2 : -0.2) * step;
        return distance * layer +
               0.008 * std::sin((7.0 + layer % 10) * x + phase) * std::cos((9.0 - layer % 7) * y);
    };
    DeformingScene scene;
    for (int layer = 0; layer < kLayers; ++layer)
    {
        appendMesh(scene.mesh,
                   makeSheet(triangles / kLayers,
                             [&](double x, double y) { return height(layer, 0, x, y); }));
    }
    scene.frames.push_back(scene.mesh.vertices);
    const std::size_t ofLayer = scene.mesh.vertices.size() / kLayers;
    for (int step = 1; step <= steps; ++step)
    {
        scene.frames.push_back(scene.frames.back());
        for (std::size_t v = 0; v < scene.mesh.vertices.size(); ++v)
        {
            Eigen::Vector3d& x = scene.frames.back()[v];
            x.z() = height(static_cast<int>(v / ofLayer), step, x.x(), x.y());
        }
    }
    return scene;
}
}  // namespace

TriangleMesh sheet(int cells)
{
    TriangleMesh mesh;
    const int row = cells + 1;
    for (int i = 0; i < row * row; ++i)
    {
        mesh.vertices.emplace_back(double(i % row) / cells, double(i / row) / cells, 0.0);
    }
    for (int i = 0; i < cells * cells; ++i)
    {
        const int a = i % cells + row * (i / cells);
        mesh.triangles.push_back({a, a + 1, a + row});
        mesh.triangles.push_back({a + 1, a + row + 1, a + row});
    }
    return mesh;
}

const std::vector<std::string>& deformingScenes()
{
    static const std::vector<std::string> kNames{"breaking", "falling", "layers"};
    return kNames;
}

DeformingScene makeDeformingScene(const std::string& name, int triangles, int steps)
{
    if (name == "breaking")
    {
        return makeBreaking(triangles, steps);
    }
    if (name == "falling")
    {
        return makeFalling(triangles, steps);
    }
    if (name == "layers")
    {
        return makeLayers(triangles, steps);
    }
    throw std::invalid_argument("'" + name + "' is no scene: give breaking, falling or layers");
}
}  // namespace bullet_ccd::reference
