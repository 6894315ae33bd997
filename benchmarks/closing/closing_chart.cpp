#include "benchmarks/closing/closing_chart.h"

#include "benchmarks/closing/closing_run.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/hand/hand_file.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::ClosingResult;
using grasp::DiscreteOptions;
using grasp::LinkProximity;

/// Tolerance and gap of the two closings that enclose the reference [m].
constexpr double kFine = 1e-9;
/// How far apart the two may be [rad].
constexpr double kBracket = 1e-6;

/// What all methods of a scene share.
struct World
{
    World(const ClosingPair& pair, const ClosingChartOptions& chartOptions)
        : hand(grasp::loadHand(
              chartOptions.data / "hands" / (pair.hand + ".urdf"), std::nullopt, BULLET_CCD_SHARE)),
          object(grasp::makeGraspObject(
              pair.object, loadMeshFile(chartOptions.data / "objects" / pair.object).mesh)),
          candidates(
              {.hand = hand, .object = object, .candidates = chartOptions.candidates, .seed = 1}),
          trees(grasp::treeProximity(hand, object)),
          fcl(isFclPresent() ? fclProximity(hand, object) : nullptr)
    {
        const RunClosing continuous = runContinuous(candidates, kFine);
        const RunClosing sweep = runDiscrete(fcl != nullptr ? *fcl : *trees,
                                             hand,
                                             {.closingStep = 0.001,
                                              .contactGap = kFine,
                                              .contactLayer = 2.0 * kFine,
                                              .maxSteps = 100'000});
        for (const ClosingStart& start : closingStarts(candidates))
        {
            ClosingResult early = continuous(start).closing;
            const ClosingResult other = sweep(start).closing;
            if (grasp::postureDifference(hand, early.positions, other.positions) > kBracket)
            {
                ++dropped;
                continue;
            }
            for (std::size_t i = 0; i < early.positions.size(); ++i)
            {
                early.positions[i] = 0.5 * (early.positions[i] + other.positions[i]);
            }
            starts.push_back(start);
            references.push_back(std::move(early));
        }
    }

    grasp::HandModel hand;
    grasp::GraspObject object;
    ClosingCase candidates;
    std::unique_ptr<LinkProximity> trees;
    std::unique_ptr<LinkProximity> fcl;
    std::vector<ClosingStart> starts;
    std::vector<ClosingResult> references;
    int dropped = 0;
};
using SharedWorld = std::shared_ptr<const World>;

ChartOutcome judge(const World& world, std::size_t i, const ClosingOutcome& result)
{
    // The reference itself is known to half of the bracket.
    const double error = grasp::postureDifference(
        world.hand, result.closing.positions, world.references[i].positions);
    ChartOutcome outcome{
        .micros = result.microseconds, .hit = true, .error = std::max(error, 0.5 * kBracket)};
    if (std::isinf(result.travel))
    {
        outcome.flaw = ChartFlaw::Missed;
    }
    else if (error > kSamePosture)
    {
        outcome.flaw = ChartFlaw::Late;
    }
    else if (result.closing.status == ToiStatus::IterationLimit)
    {
        outcome.flaw = ChartFlaw::TimedOut;
    }
    return outcome;
}

/// All candidates in sequence, repeated; the median time counts.
std::vector<ChartOutcome> closeAll(const World& world, int repeats, const RunClosing& run)
{
    std::vector<ChartOutcome> outcomes(world.starts.size());
    std::vector<std::vector<double>> times(outcomes.size());
    for (int repeat = 0; repeat < repeats; ++repeat)
    {
        for (std::size_t i = 0; i < outcomes.size(); ++i)
        {
            outcomes[i] = judge(world, i, run(world.starts[i]));
            times[i].push_back(outcomes[i].micros);
        }
    }
    for (std::size_t i = 0; i < outcomes.size(); ++i)
    {
        outcomes[i].micros = medianOf(times[i]);
    }
    return outcomes;
}

ChartMethod ours(const SharedWorld& world, int repeats)
{
    ChartMethod method{.name = "ours", .settings = {}};
    for (int exponent = 3; exponent <= 7; ++exponent)
    {
        const double tolerance = std::pow(10.0, -exponent);
        method.settings.push_back(
            {.label = fmt::format("1e-{} m", exponent), .run = [=] {
                 return closeAll(*world, repeats, runContinuous(world->candidates, tolerance));
             }});
    }
    return method;
}

ChartMethod stepping(const SharedWorld& world,
                     const std::string& name,
                     LinkProximity& proximity,
                     const DiscreteOptions& options,
                     const std::vector<double>& steps)
{
    ChartMethod method{.name = name, .settings = {}};
    for (const double step : steps)
    {
        DiscreteOptions asked = options;
        asked.closingStep = step;
        asked.maxSteps = 100'000;
        method.settings.push_back({.label = fmt::format("{:g} rad", step), .run = [=, &proximity] {
                                       return closeAll(
                                           *world, 1, runDiscrete(proximity, world->hand, asked));
                                   }});
    }
    return method;
}
}  // namespace

const std::vector<ClosingPair>& closingPairs()
{
    static const std::vector<ClosingPair> kPairs{
        {"allegro_mug", "allegro/allegro_right_mesh", "ycb_16k/025_mug.obj"},
        {"sah_bottle", "schunk_sah/schunk_sah_right_mesh", "ycb_16k/006_mustard_bottle.obj"},
        {"barrett_drill", "barrett/barrett_mesh", "ycb_16k/035_power_drill.obj"},
        {"shadow_mug", "shadow/shadow_right_mesh", "ycb_16k/025_mug.obj"},
        {"svh_drill", "schunk_svh/schunk_svh_right_mesh", "ycb_16k/035_power_drill.obj"},
        {"gripper_bottle", "panda_gripper/panda_gripper_mesh", "ycb_16k/006_mustard_bottle.obj"}};
    return kPairs;
}

ChartScene makeClosingScene(const ClosingPair& pair, const ClosingChartOptions& options)
{
    const auto world = std::make_shared<const World>(pair, options);
    ChartScene scene{.name = pair.name,
                     .title = fmt::format("{}: {} grasps", pair.name, world->starts.size()),
                     .methods = {}};
    if (world->dropped > 0)
    {
        scene.title += fmt::format(" ({} without reference)", world->dropped);
    }
    // A larger gap than the usual one would stop earlier, a smaller one costs more halvings.
    const DiscreteOptions usual{};
    const DiscreteOptions fine{.contactGap = 1e-6, .contactLayer = 2e-6};
    const std::vector<double> steps{2.0, 1.0, 0.5, 0.1, 0.02, 0.01};
    scene.methods.push_back(ours(world, options.repeats));
    scene.methods.push_back(stepping(world, "stepping, own trees", *world->trees, usual, steps));
    scene.methods.push_back(
        stepping(world, "stepping, own trees, gap 1 µm", *world->trees, fine, steps));
    if (world->fcl != nullptr)
    {
        scene.methods.push_back(
            stepping(world, "stepping, FCL", *world->fcl, usual, {1.0, 0.1, 0.01}));
    }
    return scene;
}
}  // namespace bullet_ccd::benchmarks
