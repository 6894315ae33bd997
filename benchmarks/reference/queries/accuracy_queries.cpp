#include "benchmarks/reference/queries/accuracy_queries.h"

#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/print_scene.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <array>
#include <cmath>
#include <numbers>
#include <ostream>

namespace bullet_ccd::reference
{
namespace
{
constexpr std::array kRows{3, 7, 22, 71, 224};
constexpr double kRadius = 0.1;

/// The meshes of A (0) and B (1), which differ.
const SsvTree& treeOf(int body, std::size_t size)
{
    static const std::vector<SsvTree> kTrees = []
    {
        std::vector<SsvTree> trees;
        for (const double phase : {0.0, 1.0})
        {
            for (const int rows : kRows)
            {
                trees.push_back(buildSsvTree(wavyBall(rows, kRadius, phase)));
            }
        }
        return trees;
    }();
    return kTrees[static_cast<std::size_t>(body) * kRows.size() + size];
}

Judgement judgementOf(const AccuracyQuery& query, const ToiResult& found, const ToiResult& exact)
{
    const SsvTree& treeA = treeOf(0, query.sizeA);
    const SsvTree& treeB = treeOf(1, query.sizeB);
    const auto wrong = [&](Verdict verdict, double distance)
    { return Judgement{.verdict = verdict, .time = found.time, .distance = distance}; };
    if (found.status == ToiStatus::Separated)
    {
        return exact.status == ToiStatus::Separated ? Judgement{} : wrong(Verdict::Missed, 0.0);
    }
    if (found.status != ToiStatus::Hit)
    {
        return wrong(Verdict::WrongStatus, 0.0);
    }
    constexpr double kFar = 1.0;
    const double distance =
        treeDistance(treeA, treeB, query.motion.at(found.time).X_W, kFar).distance;
    if (distance <= 0.0 || found.time > exact.time)
    {
        return wrong(Verdict::Late, distance);
    }
    if (distance > query.options.tolerance)
    {
        return wrong(Verdict::False, distance);
    }
    const bool isHonest =
        found.gap >= distance * (1.0 - 1e-5) && found.gap <= query.options.tolerance;
    return isHonest ? Judgement{} : wrong(Verdict::WrongGap, distance);
}
}  // namespace

TriangleMesh wavyBall(int n, double radius, double phase)
{
    TriangleMesh mesh;
    for (int i = 0; i <= n; ++i)
    {
        for (int j = 0; j < n; ++j)
        {
            const double latitude = std::numbers::pi * i / n;
            const double longitude = 2.0 * std::numbers::pi * j / n;
            const double r = radius * (1.0 + 0.08 * std::sin(latitude) *
                                                 std::sin(5.0 * longitude + phase + latitude));
            mesh.vertices.emplace_back(r * std::sin(latitude) * std::cos(longitude),
                                       r * std::sin(latitude) * std::sin(longitude),
                                       r * std::cos(latitude));
        }
    }
    for (std::int32_t i = 0; i < n; ++i)
    {
        for (std::int32_t j = 0; j < n; ++j)
        {
            const std::int32_t a = i * n + j;
            const std::int32_t b = i * n + (j + 1) % n;
            mesh.triangles.push_back({a, a + n, b});
            mesh.triangles.push_back({b, a + n, b + n});
        }
    }
    return mesh;
}

std::vector<std::string> accuracySizes()
{
    return {"18-triangles", "98-triangles", "1k-triangles", "10k-triangles", "100k-triangles"};
}

AccuracyQuery accuracyQuery(std::uint64_t seed)
{
    Random random(seed * 0x9E3779B97F4A7C15ULL + 5);
    AccuracyQuery query{.sizeA = seed % kRows.size()};
    query.sizeB = static_cast<std::size_t>(random.integer(0, static_cast<int>(query.sizeA)));
    query.options = {.tolerance = random.logUniform(1e-6, 1e-2),
                     .anyWithin = true,
                     .strategy = static_cast<ToiStrategy>(seed / kRows.size() % 3)};
    const Eigen::Vector3d away = 3.0 * kRadius * random.direction();
    query.motion.X_W0 = random.pose(0.0);
    query.motion.X_W0.translation() = away;
    // Some graze: the middle of A passes B's by up to twice the sum of their radii.
    query.motion.v_W = -2.0 * away + 2.0 * kRadius * random.inBox(3.0);
    query.motion.w_W = random.uniform(0.0, 4.0) * random.direction();
    return query;
}

void print(std::ostream& out, const AccuracyQuery& query)
{
    out << "wavy balls of " << accuracySizes()[query.sizeA] << " (A) and "
        << accuracySizes()[query.sizeB] << " (B), strategy " << nameOf(query.options.strategy)
        << ", accuracy " << query.options.tolerance << '\n';
    printMotion(out, "motion A", query.motion);
}

AccuracyOutcome runAccuracyQuery(const AccuracyQuery& query)
{
    thread_local ToiWorkspace work;
    const RigidBody a{.tree = &treeOf(0, query.sizeA), .motion = query.motion};
    const RigidBody b{.tree = &treeOf(1, query.sizeB)};
    AccuracyOutcome outcome{.result = rigidToi(a, b, query.options, work)};
    const bool isInterval = query.options.strategy == ToiStrategy::Interval;
    const ToiOptions fine{.tolerance = 1e-9,
                          .strategy = isInterval ? ToiStrategy::BestFirst : ToiStrategy::Interval};
    outcome.judgement = judgementOf(query, outcome.result, rigidToi(a, b, fine, work));
    return outcome;
}
}  // namespace bullet_ccd::reference
