#include "benchmarks/rigid/rigid_scenes.h"

#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <memory>
#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Queries of a scene that the slowest peer is asked where one takes a second.
constexpr std::size_t kFewQueries = 10;
constexpr std::size_t kFewQuickQueries = 3;
/// Meshes above this size are large: ten thousand samples would take minutes.
constexpr std::size_t kLargeMesh = 5000;

/// What all methods of a scene share.
struct World
{
    RigidSet set;
    RigidChartOptions options;
    SsvTree treeA;
    SsvTree treeB;
    double size = 0.0;  ///< longest side of B
    std::optional<FclModel> fclA{};
    std::optional<FclModel> fclB{};
    SharedTruths truths{};

    [[nodiscard]] bool isLarge() const { return set.meshB->triangles.size() > kLargeMesh; }
    [[nodiscard]] FclBody peerA(std::size_t i) const { return {*fclA, set.queries[i].motionA}; }
    [[nodiscard]] FclBody peerB(std::size_t i) const { return {*fclB, set.queries[i].motionB}; }
};
using SharedWorld = std::shared_ptr<const World>;

/// All queries in sequence, repeated; the median time counts.
template <typename Call>
std::vector<ChartAnswer> askAll(const World& world, int repeats, const Call& call)
{
    const std::size_t count = world.set.queries.size();
    std::vector<ChartAnswer> answers(count);
    std::vector<std::vector<double>> times(count);
    for (int repeat = 0; repeat < repeats; ++repeat)
    {
        for (std::size_t i = 0; i < count; ++i)
        {
            times[i].push_back(microsecondsOf([&] { answers[i] = call(i); }));
        }
    }
    for (std::size_t i = 0; i < count; ++i)
    {
        answers[i].micros = medianOf(times[i]);
    }
    return answers;
}

ToiResult askOurs(
    const World& world, std::size_t i, double tolerance, ToiStrategy strategy, ToiWorkspace& work)
{
    const RigidBody a{.tree = &world.treeA, .motion = world.set.queries[i].motionA};
    const RigidBody b{.tree = &world.treeB, .motion = world.set.queries[i].motionB};
    return rigidToi(a, b, {.tolerance = tolerance, .strategy = strategy}, work);
}

ChartMethod ours(const SharedWorld& world, const std::string& name, ToiStrategy strategy)
{
    ChartMethod method{.name = name, .settings = {}};
    const auto work = std::make_shared<ToiWorkspace>();
    for (int exponent = 1; exponent <= 7; ++exponent)
    {
        const double tolerance = world->size * std::pow(10.0, -exponent);
        method.settings.push_back(toiSetting(
            fmt::format("1e-{}", exponent),
            tolerance,
            world->truths,
            [=]
            {
                return askAll(*world,
                              world->options.repeats,
                              [&](std::size_t i) -> ChartAnswer
                              {
                                  const ToiResult result =
                                      askOurs(*world, i, tolerance, strategy, *work);
                                  return {.hit = isContact(result.status), .time = result.time};
                              });
            }));
    }
    return method;
}

ChartAnswer sampleOurs(const World& world, std::size_t i, int samples)
{
    const RigidQuery& query = world.set.queries[i];
    const double bound = 1e-12 * world.size;  // opens only what overlaps
    for (int k = 0; k < samples; ++k)
    {
        const double t = static_cast<double>(k) / (samples - 1);
        const Eigen::Isometry3d X_BA = query.motionB.at(t).X_W.inverse() * query.motionA.at(t).X_W;
        if (treeDistance(world.treeA, world.treeB, X_BA, bound).distance <= 0.0)
        {
            return {.hit = true, .time = t};
        }
    }
    return {};
}

/// 11, 101, .. samples; ten thousand only where that takes seconds.
template <typename Sample>
ChartMethod sampling(const SharedWorld& world, const std::string& name, const Sample& sample)
{
    ChartMethod method{.name = name, .settings = {}};
    for (const int samples : {11, 101, kNaiveSamples, 10001})
    {
        if (samples > kNaiveSamples && world->isLarge())
        {
            continue;
        }
        method.settings.push_back(toiSetting(
            fmt::format("x{}", samples),
            0.0,
            world->truths,
            [=] {
                return askAll(*world, 1, [&](std::size_t i) { return sample(*world, i, samples); });
            }));
    }
    return method;
}

ChartMethod peerAdvancement(const SharedWorld& world)
{
    const auto run = [=](double timeTolerance)
    {
        const std::size_t few = world->options.quick ? kFewQuickQueries : kFewQueries;
        const std::size_t all = world->set.queries.size();
        const std::size_t count = world->isLarge() ? std::min(few, all) : all;
        return runWithLimit(count,
                            world->options.peerSeconds,
                            [&](std::size_t i)
                            {
                                ChartAnswer answer;
                                const double micros = microsecondsOf(
                                    [&]
                                    {
                                        const FclAnswer peer = fclAdvancement(
                                            world->peerA(i), world->peerB(i), timeTolerance);
                                        answer = {.hit = peer.hit, .time = peer.time};
                                    });
                                answer.micros = micros;
                                return answer;
                            });
    };
    return {.name = "FCL conservative advancement",
            .settings = {toiSetting("1e-4", 0.0, world->truths, [run] { return run(1e-4); })}};
}

ChartMethod bulletMethod(const SharedWorld& world,
                         const std::string& name,
                         BulletCast cast,
                         const std::vector<double>& margins)
{
    ChartMethod method{.name = name, .settings = {}};
    for (const double margin : margins)
    {
        const auto a = std::make_shared<BulletHull>(*world->set.meshA, margin);
        const auto b = std::make_shared<BulletHull>(*world->set.meshB, margin);
        method.settings.push_back(toiSetting(
            fmt::format("margin {}", margin),
            2.0 * margin,
            world->truths,
            [=]
            {
                return askAll(*world,
                              world->options.repeats,
                              [&](std::size_t i) -> ChartAnswer
                              {
                                  const RigidQuery& query = world->set.queries[i];
                                  const BulletAnswer answer =
                                      bulletCast(cast, *a, query.motionA, *b, query.motionB);
                                  return {.hit = answer.hit, .time = answer.time};
                              });
            }));
    }
    return method;
}

/// For sets without references: our time at a tolerance of 1e-9 of the size, then the peer's first
/// overlap behind it; its samples before exclude an earlier one.
ChartTruth findTruth(const World& world, std::size_t i, ToiWorkspace& work)
{
    const ToiResult ours = askOurs(world, i, 1e-9 * world.size, ToiStrategy::BestFirst, work);
    if (!world.fclA)
    {
        return {.hit = isContact(ours.status), .time = ours.time, .slack = 1e-8};
    }
    const FclAnswer sampled = fclNaive(world.peerA(i), world.peerB(i), kNaiveSamples);
    const double end = sampled.hit ? sampled.time : 1.0;
    if (const auto first = firstOverlap(world.peerA(i), world.peerB(i), ours.time, end);
        first && *first <= end)
    {
        return {.hit = true, .time = *first};
    }
    double clearance = world.size;
    for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0, ours.time})
    {
        clearance = std::min(clearance, fclDistance(world.peerA(i), world.peerB(i), t));
    }
    return {.clearance = clearance};
}

std::vector<ChartTruth> truthsOf(const World& world)
{
    std::vector<ChartTruth> truths;
    ToiWorkspace work;
    for (std::size_t i = 0; i < world.set.queries.size(); ++i)
    {
        if (world.set.references.empty())
        {
            truths.push_back(findTruth(world, i, work));
            continue;
        }
        const RigidReference& known = world.set.references[i];
        truths.push_back({.hit = known.hit,
                          .time = known.time,
                          .slack = 1e-11 + world.set.vertexRounding / known.speedBound,
                          .clearance = known.closestDistance});
    }
    return truths;
}

void addPeers(const SharedWorld& world, ChartScene& scene)
{
    if (world->fclA)
    {
        const auto sample = [](const World& w, std::size_t i, int samples) -> ChartAnswer
        {
            const FclAnswer answer = fclNaive(w.peerA(i), w.peerB(i), samples);
            return {.hit = answer.hit, .time = answer.time};
        };
        scene.methods.push_back(sampling(world, "FCL naive sampling", sample));
        scene.methods.push_back(peerAdvancement(world));
    }
    if (isBulletPresent() && world->set.name.starts_with("convex_"))
    {
        scene.methods.push_back(
            bulletMethod(world, "Bullet continuous convex", BulletCast::Continuous, {0.0, 0.04}));
        scene.methods.push_back(
            bulletMethod(world, "Bullet GJK convex cast", BulletCast::Gjk, {0.0, 0.04}));
        scene.methods.push_back(
            bulletMethod(world, "Bullet subsimplex cast", BulletCast::Subsimplex, {0.0, 0.04}));
    }
}
}  // namespace

const std::vector<std::string>& rigidChartSets()
{
    static const std::vector<std::string> kSets{"bunny_ident",
                                                "bunny_near",
                                                "bunny_rot",
                                                "knot_64k",
                                                "finger",
                                                "plate",
                                                "tunnel",
                                                "convex_hull162_trans",
                                                "convex_hull162_rot40"};
    return kSets;
}

ChartScene makeRigidScene(const std::string& set,
                          MeshLibrary& meshes,
                          const RigidChartOptions& options)
{
    const std::size_t most = options.quick ? 12 : 100;
    RigidSet queries = makeRigidSet(set, meshes);
    queries.queries.resize(std::min(most, queries.queries.size()));
    queries.references.resize(std::min(most, queries.references.size()));
    const Eigen::Vector3d sizes = bounds(*queries.meshB).sizes();
    const auto world = std::make_shared<World>(World{.set = queries,
                                                     .options = options,
                                                     .treeA = buildSsvTree(*queries.meshA),
                                                     .treeB = buildSsvTree(*queries.meshB),
                                                     .size = sizes.maxCoeff()});
    if (isFclPresent())
    {
        world->fclA.emplace(*queries.meshA);
        world->fclB.emplace(*queries.meshB);
    }
    world->truths = std::make_shared<const std::vector<ChartTruth>>(truthsOf(*world));
    ChartScene scene{.name = set,
                     .title = fmt::format("{} ({} x {} triangles)",
                                          set,
                                          queries.meshA->triangles.size(),
                                          queries.meshB->triangles.size()),
                     .methods = {}};
    scene.methods.push_back(ours(world, "best-first", ToiStrategy::BestFirst));
    scene.methods.push_back(ours(world, "interval", ToiStrategy::Interval));
    scene.methods.push_back(ours(world, "c2a", ToiStrategy::C2A));
    scene.methods.push_back(sampling(world, "overlap sampling, own tree", sampleOurs));
    addPeers(world, scene);
    return scene;
}
}  // namespace bullet_ccd::benchmarks
