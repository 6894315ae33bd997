// Time of impact of two knotted tubes of growing size; the answer is checked before it is timed.
//
// Every query is one of 64 seeded motions that begin apart. "checked" means: 31 samples of
// the motion with the exact mesh distance find no contact before the reported time, and at that
// time the surfaces are within the tolerance.
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

namespace
{
using namespace bullet_ccd;
using Eigen::Vector3d;

constexpr double kTolerance = 1e-6;

/// A tube of radius 0.012 along a (2, 3) torus knot of radius 0.05 to 0.11 m: interlocking, no
/// convex parts to speak of.
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
        }
    }
    for (int i = 0; i < along; ++i)
    {
        for (int k = 0; k < around; ++k)
        {
            const int i1 = (i + 1) % along;
            const int k1 = (k + 1) % around;
            mesh.triangles.push_back({i * around + k, i1 * around + k, i1 * around + k1});
            mesh.triangles.push_back({i * around + k, i1 * around + k1, i * around + k1});
        }
    }
    return mesh;
}

/// Seeded motions of A that start on a sphere around B and pass through it, turning by up to 2 rad.
std::vector<RigidMotion> makeMotions()
{
    std::mt19937_64 random(7);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto direction = [&]
    { return Vector3d(gauss(random), gauss(random), gauss(random)).normalized(); };
    std::vector<RigidMotion> motions;
    for (int i = 0; i < 64; ++i)
    {
        RigidMotion motion;
        const Vector3d from = direction();
        motion.X_W0.linear() =
            Eigen::AngleAxisd(3.0 * uniform(random), direction()).toRotationMatrix();
        motion.X_W0.translation() = 0.35 * from;
        motion.v_W = -0.5 * from + 0.4 * direction();
        motion.w_W = 2.0 * uniform(random) * direction();
        motions.push_back(motion);
    }
    return motions;
}

void checkAnswer(const RigidBody& a, const RigidBody& b, const ToiResult& result)
{
    constexpr int kSamples = 30;
    const double end = result.status == ToiStatus::Hit ? result.time : 1.0;
    for (int i = 0; i <= kSamples; ++i)
    {
        const double t = end * i / kSamples;
        const double d =
            treeDistance(*a.tree, *b.tree, b.motion.X_W0.inverse() * a.motion.at(t).X_W, 1e-4)
                .distance;
        if (d <= 0.0 || (i == kSamples && result.status == ToiStatus::Hit && d > kTolerance))
        {
            throw std::logic_error("wrong answer: distance " + std::to_string(d) +
                                   " at t = " + std::to_string(t));
        }
    }
}

void rigidToiOfKnots(benchmark::State& state)
{
    const int around = 16;
    const int along = static_cast<int>(state.range(0)) / (2 * around);
    const SsvTree knot = buildSsvTree(makeKnot(along, around));
    const RigidBody resting{.tree = &knot, .motion = {}};
    const std::vector<RigidMotion> motions = makeMotions();
    ToiWorkspace work;
    int hits = 0;
    for (const RigidMotion& motion : motions)
    {
        const RigidBody moving{.tree = &knot, .motion = motion};
        const ToiResult result = rigidToi(moving, resting, {.tolerance = kTolerance}, work);
        checkAnswer(moving, resting, result);
        hits += result.status == ToiStatus::Hit ? 1 : 0;
    }

    double nodePairs = 0.0;
    double trianglePairs = 0.0;
    std::size_t next = 0;
    for (auto _ : state)
    {
        const RigidBody moving{.tree = &knot, .motion = motions[next]};
        const ToiResult result = rigidToi(moving, resting, {.tolerance = kTolerance}, work);
        nodePairs += static_cast<double>(result.counters.nodePairs);
        trianglePairs += static_cast<double>(result.counters.trianglePairs);
        next = (next + 1) % motions.size();
    }
    state.counters["hits_of_64"] = hits;
    state.counters["node_pairs"] =
        benchmark::Counter(nodePairs, benchmark::Counter::kAvgIterations);
    state.counters["triangle_pairs"] =
        benchmark::Counter(trianglePairs, benchmark::Counter::kAvgIterations);
}
BENCHMARK(rigidToiOfKnots)
    ->RangeMultiplier(4)
    ->Range(1 << 10, 1 << 16)
    ->Unit(benchmark::kMicrosecond);

void buildTree(benchmark::State& state)
{
    const int around = 16;
    const TriangleMesh mesh = makeKnot(static_cast<int>(state.range(0)) / (2 * around), around);
    for (auto _ : state)
    {
        benchmark::DoNotOptimize(buildSsvTree(mesh));
    }
    state.counters["bytes_per_triangle"] = 2.0 * sizeof(SsvNode) + sizeof(std::array<Vector3d, 3>);
}
BENCHMARK(buildTree)->RangeMultiplier(4)->Range(1 << 10, 1 << 16)->Unit(benchmark::kMillisecond);
}  // namespace

BENCHMARK_MAIN();
