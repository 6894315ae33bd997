// Points of the rigid chart as JSON; benchmarks/run chart runs this program and draws them.
#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "benchmarks/support/chart.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <memory>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Meshes above this size are large: ten thousand samples would take minutes.
constexpr std::size_t kLargeMesh = 5000;

/// What all methods of a scene share.
struct World
{
    struct Hulls
    {
        BulletHull a;
        BulletHull b;
    };

    RigidSet set;
    int passes = 1;
    std::size_t slowQueries = 10;  ///< that a peer is asked that may take a second for one
    double peerSeconds = 1.0;      ///< its limit
    SsvTree treeA;
    SsvTree treeB;
    double size = 0.0;  ///< longest side of B
    FclModel fclA;
    FclModel fclB;
    std::map<double, Hulls> hulls{};  ///< by margin
    SharedTruths truths{};

    [[nodiscard]] bool isLarge() const { return set.meshB->triangles.size() > kLargeMesh; }
    [[nodiscard]] FclBody peerA(std::size_t i) const { return {fclA, set.queries[i].motionA}; }
    [[nodiscard]] FclBody peerB(std::size_t i) const { return {fclB, set.queries[i].motionB}; }
};
using SharedWorld = std::shared_ptr<const World>;

ToiResult askOurs(
    const World& world, std::size_t i, double tolerance, ToiStrategy strategy, ToiWorkspace& work)
{
    const RigidBody a{.tree = &world.treeA, .motion = world.set.queries[i].motionA};
    const RigidBody b{.tree = &world.treeB, .motion = world.set.queries[i].motionB};
    return rigidToi(a, b, {.tolerance = tolerance, .strategy = strategy}, work);
}

ChartMethod ours(const SharedWorld& world, const std::string& name, ToiStrategy strategy)
{
    const auto answer = [=, work = std::make_shared<ToiWorkspace>()](
                            std::size_t i, double tolerance) -> ChartAnswer
    {
        const ToiResult result = askOurs(*world, i, tolerance, strategy, *work);
        return {.hit = isContact(result.status), .time = result.time};
    };
    return toiMethod(name, world->truths, tolerances(1, 7, world->size), answer, world->passes);
}

ChartAnswer sampleOurs(const World& world, std::size_t i, double samples)
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

ChartAnswer samplePeer(const World& world, std::size_t i, double samples)
{
    const FclAnswer answer = fclNaive(world.peerA(i), world.peerB(i), static_cast<int>(samples));
    return {.hit = answer.hit, .time = answer.time};
}

/// Ten thousand samples only where that takes seconds.
ChartMethod sampling(const SharedWorld& world,
                     const std::string& name,
                     ChartAnswer (*sample)(const World& world, std::size_t i, double samples))
{
    std::vector<int> counts{11, 101, kNaiveSamples};
    if (!world->isLarge())
    {
        counts.push_back(10001);
    }
    return toiMethod(name,
                     world->truths,
                     sampleCounts(counts),
                     [=](std::size_t i, double samples) { return sample(*world, i, samples); });
}

ChartMethod peerAdvancement(const SharedWorld& world)
{
    const auto run = [=](double timeTolerance)
    {
        const std::size_t all = world->set.queries.size();
        const std::size_t count = world->isLarge() ? std::min(world->slowQueries, all) : all;
        return runWithLimit(count,
                            world->peerSeconds,
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

ChartMethod bulletMethod(const SharedWorld& world, const std::string& name, BulletCast cast)
{
    const auto answer = [=](std::size_t i, double margin) -> ChartAnswer
    {
        const RigidQuery& query = world->set.queries[i];
        const World::Hulls& hulls = world->hulls.at(margin);
        const BulletAnswer found = bulletCast(cast, hulls.a, query.motionA, hulls.b, query.motionB);
        return {.hit = found.hit, .time = found.time};
    };
    std::vector<ToiSetting> settings;
    for (const auto& [margin, hulls] : world->hulls)
    {
        settings.push_back({fmt::format("margin {}", margin), margin, 2.0 * margin});
    }
    return toiMethod(name, world->truths, settings, answer, world->passes);
}

/// For sets without references: our time at a tolerance of 1e-9 of the size, then the peer's first
/// overlap behind it; its samples before exclude an earlier one.
ChartTruth findTruth(const World& world, std::size_t i, ToiWorkspace& work)
{
    const ToiResult ours = askOurs(world, i, 1e-9 * world.size, ToiStrategy::BestFirst, work);
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
    scene.methods.push_back(sampling(world, "FCL naive sampling", samplePeer));
    scene.methods.push_back(peerAdvancement(world));
    if (!world->hulls.empty())
    {
        scene.methods.push_back(
            bulletMethod(world, "Bullet continuous convex", BulletCast::Continuous));
        scene.methods.push_back(bulletMethod(world, "Bullet GJK convex cast", BulletCast::Gjk));
        scene.methods.push_back(
            bulletMethod(world, "Bullet subsimplex cast", BulletCast::Subsimplex));
    }
}

/// Three strategies of ours and samples on our hierarchy; FCL's advancement and samples; Bullet's
/// casts where shapes are convex.
ChartScene makeScene(const std::string& set, const ChartOptions& options, double peerSeconds)
{
    // FCL takes seconds for each of the worst queries.
    const std::size_t most = options.quick || set.starts_with("worst_") ? 12 : 100;
    MeshLibrary meshes(options.data);
    RigidSet queries = makeRigidSet(set, meshes);
    queries.queries.resize(std::min(most, queries.queries.size()));
    queries.references.resize(std::min(most, queries.references.size()));
    const Eigen::Vector3d sizes = bounds(*queries.meshB).sizes();
    const auto world = std::make_shared<World>(World{.set = queries,
                                                     .passes = options.repeats,
                                                     .slowQueries = options.quick ? 3U : 10U,
                                                     .peerSeconds = peerSeconds,
                                                     .treeA = buildSsvTree(*queries.meshA),
                                                     .treeB = buildSsvTree(*queries.meshB),
                                                     .size = sizes.maxCoeff(),
                                                     .fclA = FclModel(*queries.meshA),
                                                     .fclB = FclModel(*queries.meshB)});
    if (set.starts_with("convex_"))
    {
        for (const double margin : {0.0, 0.04})
        {
            world->hulls.emplace(margin,
                                 World::Hulls{BulletHull(*queries.meshA, margin),
                                              BulletHull(*queries.meshB, margin)});
        }
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
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    double peerSeconds = 1.0;
    ChartFamily family = toiFamily("rigid", "Time of contact of two rigid bodies");
    family.peers = {fclVersion(), "Bullet"};
    return runChart(argc,
                    argv,
                    {.family = family,
                     .scenes = {"bunny_ident",
                                "bunny_near",
                                "bunny_rot",
                                "knot_64k",
                                "finger",
                                "worst_gears",
                                "plate",
                                "tunnel",
                                "flat_box_10k",
                                "convex_hull162_trans",
                                "convex_hull162_rot40"},
                     .options = {{"--peer-seconds",
                                  &peerSeconds,
                                  "limit of one query of FCL's conservative advancement"}},
                     .makeScene = [&](const std::string& scene, const ChartOptions& options)
                     { return makeScene(scene, options, peerSeconds); }});
}
