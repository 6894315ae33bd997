#include "bullet_ccd/reduce/accuracy_costs.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/reduce/reduce_mesh.h"
#include "bullet_ccd/toi/model_use.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <random>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

constexpr std::array kAccuracies{1e-6, 1e-5, 1e-4, 5e-4, 1e-3, 2e-3, 5e-3};
constexpr int kQueries = 60;
constexpr int kRepeats = 3;
constexpr std::size_t kColdQueries = 3;

/// The motion of A; B rests.
using Motions = std::vector<RigidMotion>;

class Stopwatch
{
public:
    [[nodiscard]] double seconds() const
    {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    }

private:
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double sizeOf(const TriangleMesh& mesh)
{
    return bounds(mesh).sizes().maxCoeff();
}

Motions randomMotions(const SsvTree& bodyA, const SsvTree& bodyB)
{
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    const auto direction = [&]() -> Vector3d
    { return Vector3d(normal(random), normal(random), normal(random)).normalized(); };
    Motions motions(kQueries);
    const double reach = bodyA.radius() + bodyB.radius();
    for (RigidMotion& motion : motions)
    {
        const Eigen::Quaterniond turn(
            normal(random), normal(random), normal(random), normal(random));
        const Vector3d from = 1.1 * reach * direction();
        // Past the middle of B by up to half of its radius.
        const Vector3d towards = 0.5 * bodyB.radius() * direction();
        motion.X_W0.linear() = turn.normalized().toRotationMatrix();
        motion.X_W0.translation() = bodyB.origin() + from - motion.X_W0.linear() * bodyA.origin();
        motion.w_W = direction();
        motion.v_W =
            2.0 * (towards - from) - motion.w_W.cross(motion.X_W0.linear() * bodyA.origin());
    }
    return motions;
}

double bytesOf(const SsvTree& tree)
{
    const TriangleMesh& mesh = tree.mesh();
    return static_cast<double>(
        tree.nodes().size_bytes() + mesh.vertices.size() * sizeof(Vector3d) +
        mesh.triangles.size() *
            (sizeof(Triangle) + sizeof(std::array<Vector3d, 3>) + sizeof(std::int32_t)));
}

/// The smaller mesh, or the full one.
TriangleMesh meshWithin(const TriangleMesh& mesh, double accuracy)
{
    std::optional<ReducedModel> model =
        reduceMesh(mesh, {.accuracy = accuracy, .kind = ModelKind::Mesh});
    return model ? std::move(model->mesh) : mesh;
}

void ask(const SsvTree& modelA,
         const SsvTree& modelB,
         const SsvTree& bodyA,
         const SsvTree& bodyB,
         const Motions& motions,
         AccuracyCost& row)
{
    const ToiOptions options{.tolerance = row.tolerance,
                             .minimumSeparation = row.minimumSeparation};
    ToiWorkspace work;
    std::vector<double> times;
    for (const RigidMotion& motion : motions)
    {
        ToiResult result;
        std::vector<double> repeats;
        for (int k = 0; k < kRepeats; ++k)
        {
            const Stopwatch watch;
            result =
                rigidToi({.tree = &modelA, .motion = motion}, {.tree = &modelB}, options, work);
            repeats.push_back(1e6 * watch.seconds());
        }
        times.push_back(median(repeats));
        if (result.status != ToiStatus::Hit)
        {
            continue;
        }
        const double gap =
            treeDistance(
                bodyA, bodyB, motion.at(result.time).X_W, std::numeric_limits<double>::infinity())
                .distance;
        const double allowed = row.accuracy > 0.0 ? row.accuracy : row.tolerance;
        ++row.contacts;
        row.largestGap = std::max(row.largestGap, gap);
        row.broken += gap > 0.0 && gap <= allowed ? 0 : 1;
    }
    row.microseconds = median(times);
    row.trianglesA = modelA.mesh().triangles.size();
    row.trianglesB = modelB.mesh().triangles.size();
    row.bytes = bytesOf(modelA) + bytesOf(modelB);
}
/// Asks the bodies themselves, warm and cold.
void askBodies(const SsvTree& bodyA,
               const SsvTree& bodyB,
               const Motions& motions,
               AccuracyCost& row)
{
    const bool isAccuracy = row.accuracy > 0.0;
    const ToiOptions options{.tolerance = isAccuracy ? row.accuracy : row.tolerance,
                             .anyWithin = isAccuracy};
    const auto query = [&](const SsvTree& a, const SsvTree& b, std::size_t i, ToiWorkspace& work)
    { return rigidToi({.tree = &a, .motion = motions[i]}, {.tree = &b}, options, work); };
    ToiWorkspace work;
    ModelUse use;
    std::vector<double> times;
    for (std::size_t i = 0; i < motions.size(); ++i)
    {
        noteModelUse(work, &use);
        const ToiResult result = query(bodyA, bodyB, i, work);
        noteModelUse(work, nullptr);
        row.pairs +=
            static_cast<double>(result.counters.nodePairs + result.counters.trianglePairs) /
            static_cast<double>(motions.size());
        std::vector<double> repeats;
        for (int k = 0; k < kRepeats; ++k)
        {
            const Stopwatch watch;
            static_cast<void>(query(bodyA, bodyB, i, work));
            repeats.push_back(1e6 * watch.seconds());
        }
        times.push_back(median(repeats));
    }
    row.warmMicroseconds = median(times);
    row.trianglesSeen = use.count();
    std::vector<double> cold;
    std::vector<double> built;
    for (std::size_t i = 0; i < kColdQueries; ++i)
    {
        TriangleMesh meshA = bodyA.mesh();
        TriangleMesh meshB = bodyB.mesh();
        const Stopwatch watch;
        const SsvTree treeA = buildSsvTreeAsNeeded(std::move(meshA));
        const SsvTree treeB = buildSsvTreeAsNeeded(std::move(meshB));
        static_cast<void>(query(treeA, treeB, i, work));
        cold.push_back(1e3 * watch.seconds());
        built.push_back(static_cast<double>(treeA.builtTriangles() + treeB.builtTriangles()));
    }
    row.coldMilliseconds = median(cold);
    row.trianglesBuilt = static_cast<std::size_t>(median(built));
}
}  // namespace

std::vector<AccuracyCost> measureAccuracies(
    const SsvTree& bodyA,
    const SsvTree& bodyB,
    const std::function<bool(std::size_t, std::size_t)>& progress)
{
    const Motions motions = randomMotions(bodyA, bodyB);
    const double smallest =
        5.0 * std::max(smallestAccuracy(bodyA.mesh()), smallestAccuracy(bodyB.mesh()));
    const double largest = 0.25 * std::min(sizeOf(bodyA.mesh()), sizeOf(bodyB.mesh()));

    std::vector<AccuracyCost> rows;
    AccuracyCost full{.tolerance = 1e-6 * sizeOf(bodyB.mesh())};
    ask(bodyA, bodyB, bodyA, bodyB, motions, full);
    askBodies(bodyA, bodyB, motions, full);
    rows.push_back(full);
    for (const double accuracy : kAccuracies)
    {
        if (accuracy < smallest || accuracy > largest)
        {
            continue;
        }
        if (!progress(rows.size(), kAccuracies.size() + 1))
        {
            break;
        }
        AccuracyCost row{.accuracy = accuracy,
                         .modelAccuracy = accuracy / 5.0,
                         .minimumSeparation = 2.0 * accuracy / 5.0,
                         .tolerance = accuracy / 5.0};
        const Stopwatch reducing;
        TriangleMesh smallA = meshWithin(bodyA.mesh(), row.modelAccuracy);
        TriangleMesh smallB =
            &bodyA == &bodyB ? smallA : meshWithin(bodyB.mesh(), row.modelAccuracy);
        row.reduceSeconds = reducing.seconds();
        const Stopwatch building;
        const SsvTree modelA = buildSsvTree(std::move(smallA));
        const SsvTree modelB = buildSsvTree(std::move(smallB));
        row.buildSeconds = building.seconds();
        ask(modelA, modelB, bodyA, bodyB, motions, row);
        askBodies(bodyA, bodyB, motions, row);
        rows.push_back(row);
    }
    return rows;
}
}  // namespace bullet_ccd
