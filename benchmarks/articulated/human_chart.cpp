#include "benchmarks/articulated/human_chart.h"

#include "benchmarks/articulated/human_peers.h"
#include "benchmarks/articulated/human_run.h"
#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <memory>

namespace bullet_ccd::benchmarks
{
namespace
{
/// What all methods of a scene share.
struct World
{
    World(const HumanChartOptions& chartOptions, const std::string& motion)
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

    HumanChartOptions options;
    HumanScene scene;
    Environment environment;
    FclHuman peer;
    std::vector<const HumanQuery*> queries;
    SharedTruths truths;
};
using SharedWorld = std::shared_ptr<const World>;

/// Settings of a method.
struct Asked
{
    int smallest = 7;  ///< tolerances from 1e-2 m down to 10^-smallest
    int repeats = 1;
    std::size_t queries = SIZE_MAX;  ///< the first ones only
};

/// Queries in sequence, repeated; the median time counts.
template <typename Call>
std::vector<ChartAnswer> askAll(const World& world, const Asked& asked, const Call& call)
{
    std::vector<ChartAnswer> answers(std::min(asked.queries, world.queries.size()));
    std::vector<std::vector<double>> times(answers.size());
    for (int repeat = 0; repeat < asked.repeats; ++repeat)
    {
        for (std::size_t i = 0; i < answers.size(); ++i)
        {
            times[i].push_back(microsecondsOf([&] { answers[i] = call(*world.queries[i]); }));
        }
    }
    for (std::size_t i = 0; i < answers.size(); ++i)
    {
        answers[i].micros = medianOf(times[i]);
    }
    return answers;
}

template <typename Ask>
ChartMethod byTolerance(const SharedWorld& world,
                        const std::string& name,
                        const Asked& asked,
                        const Ask& ask)
{
    ChartMethod method{.name = name, .settings = {}};
    const auto work = std::make_shared<ToiWorkspace>();
    for (int exponent = 2; exponent <= asked.smallest; ++exponent)
    {
        const double tolerance = std::pow(10.0, -exponent);
        method.settings.push_back(
            toiSetting(fmt::format("1e-{}", exponent),
                       tolerance,
                       world->truths,
                       [=]
                       {
                           return askAll(*world,
                                         asked,
                                         [&](const HumanQuery& query)
                                         { return ask(*world, query, tolerance, *work); });
                       }));
    }
    return method;
}

ChartMethod stageMethod(const SharedWorld& world, const Stage& stage)
{
    const auto ask = [options = stage.options](const World& w,
                                               const HumanQuery& query,
                                               double tolerance,
                                               ToiWorkspace& work) -> ChartAnswer
    {
        ArticulatedToiOptions asked = options;
        asked.toi.tolerance = tolerance;
        const ArticulatedToiResult result =
            articulatedToi(w.scene.body(query), w.environment, asked, work);
        return {.hit = isContact(result.status), .time = result.time};
    };
    // With bounds of first order, steps shrink with the distance: a query takes a second, small
    // tolerances take minutes.
    const bool isFast = stage.options.bound == MotionBound::SecondOrder;
    const Asked slow{.smallest = 4, .queries = world->options.quick ? 3U : 12U};
    return byTolerance(
        world, stage.name, isFast ? Asked{.repeats = world->options.repeats} : slow, ask);
}

ChartMethod pairwise(const SharedWorld& world)
{
    const auto ask = [](const World& w,
                        const HumanQuery& query,
                        double tolerance,
                        ToiWorkspace& work) -> ChartAnswer
    {
        const double time = rigidTime(w.scene, query, tolerance, work);
        return {.hit = time <= 1.0, .time = std::min(time, 1.0)};
    };
    return byTolerance(world, "rigidToi on each pair", {.repeats = world->options.repeats}, ask);
}

ChartMethod sampling(const SharedWorld& world)
{
    ChartMethod method{.name = "FCL sampling of all links", .settings = {}};
    for (const int samples : {11, 101, kNaiveSamples})
    {
        method.settings.push_back(toiSetting(
            fmt::format("x{}", samples),
            0.0,
            world->truths,
            [=]
            {
                return askAll(*world,
                              {},
                              [&](const HumanQuery& query) -> ChartAnswer
                              {
                                  const double time = world->peer.firstSample(query, samples);
                                  return {.hit = time <= 1.0, .time = std::min(time, 1.0)};
                              });
            }));
    }
    return method;
}

/// First overlap from `low` on, where nothing overlaps, up to `high`, where something does.
double bisect(const World& world, const HumanQuery& query, double low, double high)
{
    // The first of steps that double, so that a short overlap right behind `low` is not passed by.
    for (double step = 1e-9; low + step < high; step *= 2.0)
    {
        if (world.peer.overlaps(query, low + step))
        {
            high = low + step;
        }
    }
    while (high - low > 1e-12)
    {
        const double middle = 0.5 * (low + high);
        (world.peer.overlaps(query, middle) ? high : low) = middle;
    }
    return high;
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
        return {.hit = true, .time = bisect(world, query, low, sampled)};
    }
    if (isContact(ours.status))
    {
        return {.hit = true, .time = ours.time, .slack = 1e-6};  // between two samples
    }
    return {.clearance = clearanceOf(world, query)};
}
}  // namespace

ChartScene makeHumanChartScene(const std::string& motion, const HumanChartOptions& options)
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
    for (const Stage& stage : humanStages(true))
    {
        scene.methods.push_back(stageMethod(world, stage));
    }
    scene.methods.push_back(pairwise(world));
    scene.methods.push_back(sampling(world));
    return scene;
}
}  // namespace bullet_ccd::benchmarks
