// Points of the articulated chart as JSON; benchmarks/run chart runs this program and draws them.
#include "benchmarks/articulated/human_peers.h"
#include "benchmarks/support/chart.h"
#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <fmt/format.h>
#include <memory>

namespace bullet_ccd::benchmarks
{
namespace
{
/// What all methods of a scene share.
struct World
{
    World(const ChartOptions& chartOptions, const std::string& motion)
        : options(chartOptions),
          scene(makeHumanScene(options.data, motion)),
          environment(scene.obstacles),
          peer(scene)
    {
        for (const HumanQuery& query : scene.queries)
        {
            const bool isWanted = !options.quick || queries.size() < 12;
            if (isWanted && query.masks.empty())
            {
                queries.push_back(&query);
            }
        }
    }

    ChartOptions options;
    HumanScene scene;
    Environment environment;
    FclHuman peer;
    std::vector<const HumanQuery*> queries;
    SharedTruths truths;
};
using SharedWorld = std::shared_ptr<const World>;

ChartMethod stageMethod(const SharedWorld& world, const Stage& stage)
{
    const auto answer = [=, work = std::make_shared<ToiWorkspace>()](
                            std::size_t i, double tolerance) -> ChartAnswer
    {
        ArticulatedToiOptions asked = stage.options;
        asked.toi.tolerance = tolerance;
        const ArticulatedToiResult result =
            articulatedToi(world->scene.body(*world->queries[i]), world->environment, asked, *work);
        return {.hit = isContact(result.status), .time = result.time};
    };
    return toiMethod(stage.name, world->truths, tolerances(2, 7), answer, world->options.repeats);
}

/// kNever is no contact.
ChartAnswer answerOf(double time)
{
    return {.hit = time <= 1.0, .time = std::min(time, 1.0)};
}

ChartMethod pairwise(const SharedWorld& world)
{
    const auto answer =
        [=, work = std::make_shared<ToiWorkspace>()](std::size_t i, double tolerance)
    { return answerOf(rigidTime(world->scene, *world->queries[i], tolerance, *work)); };
    return toiMethod(
        "rigidToi on each pair", world->truths, tolerances(2, 7), answer, world->options.repeats);
}

ChartMethod sampling(const SharedWorld& world)
{
    const auto answer = [=](std::size_t i, double samples)
    {
        const int count = static_cast<int>(samples);
        return answerOf(world->peer.firstSample(*world->queries[i], count));
    };
    return toiMethod(
        "FCL sampling of all links", world->truths, sampleCounts({11, 101, kNaiveSamples}), answer);
}

/// Smallest distance of all pairs at 101 times: a bound from above of the clearance [m].
double clearanceOf(const World& world, const HumanQuery& query)
{
    const HumanScene& scene = world.scene;
    double clearance = 1.0;
    for (int sample = 0; sample <= 100; ++sample)
    {
        for (std::size_t i = 0; i < scene.links.size(); ++i)
        {
            const auto link = static_cast<std::int32_t>(i);
            const Eigen::Isometry3d X_WL =
                linkStateAt(scene.tree, query.motion, kNone, link, 0.01 * sample).X_W;
            for (const RigidBody& obstacle : scene.obstacles)
            {
                const Eigen::Isometry3d X_OL = obstacle.motion.X_W0.inverse() * X_WL;
                clearance = treeDistance(scene.links[i], *obstacle.tree, X_OL, clearance).distance;
            }
        }
    }
    return clearance;
}

ChartTruth truthOf(const World& world, const HumanQuery& query, ToiWorkspace& work)
{
    const ArticulatedToiResult ours = articulatedToi(
        world.scene.body(query), world.environment, {.toi = {.tolerance = 1e-9}}, work);
    const double sampled = world.peer.firstSample(query, kNaiveSamples);
    if (sampled <= 1.0)
    {
        const double low = isContact(ours.status) ? std::min(ours.time, sampled) : 0.0;
        const auto overlaps = [&](double t) { return world.peer.overlaps(query, t); };
        return {.hit = true, .time = firstOverlap(low, sampled, overlaps).value_or(sampled)};
    }
    if (isContact(ours.status))
    {
        return {.hit = true, .time = ours.time, .slack = 1e-6};  // between two samples
    }
    return {.clearance = clearanceOf(world, query)};
}

/// The queries of one recorded motion at which nothing intersects at the start, with the whole
/// query, without its stages, rigidToi() on each pair, and FCL's samples of all links. Truths are
/// FCL's, from our time at a tolerance of 1e-9 m on. The methods share ownership of what they need.
ChartScene makeScene(const std::string& motion, const ChartOptions& options)
{
    const auto world = std::make_shared<World>(options, motion);
    ChartScene scene{.name = motion,
                     .title = fmt::format("human, {}: {} x {} triangles",
                                          motion,
                                          world->scene.humanTriangles,
                                          world->scene.obstacleTriangles),
                     .methods = {}};
    ToiWorkspace work;
    std::vector<ChartTruth> truths;
    for (const HumanQuery* query : world->queries)
    {
        truths.push_back(truthOf(*world, *query, work));
    }
    world->truths = std::make_shared<const std::vector<ChartTruth>>(std::move(truths));
    for (const Stage& stage : humanStages())
    {
        scene.methods.push_back(stageMethod(world, stage));
    }
    scene.methods.push_back(pairwise(world));
    scene.methods.push_back(sampling(world));
    return scene;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    ChartFamily family = toiFamily("articulated", "Time of contact of a moving human");
    family.peers = {fclVersion()};
    return runChart(
        argc, argv, {.family = family, .scenes = {"walk", "run", "kick"}, .makeScene = makeScene});
}
