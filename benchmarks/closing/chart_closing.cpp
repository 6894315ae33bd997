// Points of the chart of closing hands as JSON; benchmarks/run chart runs this program and draws
// them.
#include "benchmarks/closing/closing_run.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/chart.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/hand/hand_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::ClosingResult;

/// A hand and what it grasps.
struct ClosingPair
{
    const char* name;
    const char* hand;    ///< URDF file below hands/, without its ending
    const char* object;  ///< file below objects/
};
constexpr std::array<ClosingPair, 6> kPairs{
    {{"allegro_mug", "allegro/allegro_right_mesh", "ycb_16k/025_mug.obj"},
     {"sah_bottle", "schunk_sah/schunk_sah_right_mesh", "ycb_16k/006_mustard_bottle.obj"},
     {"barrett_drill", "barrett/barrett_mesh", "ycb_16k/035_power_drill.obj"},
     {"shadow_mug", "shadow/shadow_right_mesh", "ycb_16k/025_mug.obj"},
     {"svh_drill", "schunk_svh/schunk_svh_right_mesh", "ycb_16k/035_power_drill.obj"},
     {"gripper_bottle", "panda_gripper/panda_gripper_mesh", "ycb_16k/006_mustard_bottle.obj"}}};

/// Tolerance and gap of the two closings that enclose the reference [m].
constexpr double kFine = 1e-9;
/// How far apart the two may be [rad].
constexpr double kBracket = 1e-6;

/// What all methods of a scene share.
struct World
{
    World(const ClosingPair& pair, const std::filesystem::path& data, int count)
        : hand(grasp::loadHand(
              data / "hands" / (std::string(pair.hand) + ".urdf"), std::nullopt, BULLET_CCD_SHARE)),
          object(grasp::makeGraspObject(pair.object,
                                        loadMeshFile(data / "objects" / pair.object).mesh)),
          candidates({.hand = hand, .object = object, .candidates = count, .seed = 1}),
          trees(treeProximity(hand, object)),
          fcl(fclProximity(hand, object))
    {
        const RunClosing continuous = runContinuous(candidates, kFine);
        const RunClosing sweep = runDiscrete(*fcl,
                                             hand,
                                             {.closingStep = 0.001,
                                              .contactGap = kFine,
                                              .contactLayer = 2.0 * kFine,
                                              .maxSteps = 100'000});
        for (const ClosingStart& start : closingStarts(candidates))
        {
            ClosingResult early = continuous(start).closing;
            const ClosingResult other = sweep(start).closing;
            if (postureDifference(hand, early.positions, other.positions) > kBracket)
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
    const double error =
        postureDifference(world.hand, result.closing.positions, world.references[i].positions);
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
std::vector<ChartOutcome> closeAll(const World& world, int passes, const RunClosing& run)
{
    return askAll(world.starts.size(),
                  passes,
                  [&](std::size_t i) { return judge(world, i, run(world.starts[i])); });
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
/// Approach and closing of the planner's candidates: ours at several tolerances, the discrete
/// baseline in steps of several sizes on our hierarchies and on FCL.
///
/// Errors are those of the posture: the largest difference of a joint [rad], of sliding ones ten
/// times that [m]. The reference is in between of two closings that share nothing but the hand:
/// ours at a tolerance of 1e-9 m and overlap tests in steps of 0.001 rad, bisected to the same gap,
/// by FCL. Candidates at which the two differ by more than 1e-6 rad are left
/// out for all methods; the title says how many.
ChartScene makeScene(const std::string& name, const ChartOptions& options, int candidates)
{
    const auto* pair = std::ranges::find(kPairs, name, &ClosingPair::name);
    if (pair == kPairs.end())
    {
        throw std::invalid_argument(fmt::format("scene '{}' is unknown: see --help", name));
    }
    const auto world =
        std::make_shared<const World>(*pair, options.data, options.quick ? 4 : candidates);
    ChartScene scene{.name = name,
                     .title = fmt::format("{}: {} grasps", name, world->starts.size()),
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
    scene.methods.push_back(stepping(world, "stepping, FCL", *world->fcl, usual, {1.0, 0.1, 0.01}));
    return scene;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    int candidates = 20;
    std::vector<std::string> scenes;
    for (const ClosingPair& pair : kPairs)
    {
        scenes.emplace_back(pair.name);
    }
    return runChart(argc,
                    argv,
                    {.family = {.name = "closing",
                                .title = "Approach and closing of a hand on an object",
                                .time = "time of an approach and closing",
                                .error = "posture error, of the worst joint [rad]",
                                .missed = "passed by",
                                .late = "other posture",
                                .falseHit = "",
                                .timedOut = "gave up",
                                .peers = {fclVersion()}},
                     .scenes = scenes,
                     .quickScenes = 3,
                     .options = {{"-n,--candidates", &candidates, "of a scene"}},
                     .makeScene = [&](const std::string& scene, const ChartOptions& options)
                     { return makeScene(scene, options, candidates); }});
}
