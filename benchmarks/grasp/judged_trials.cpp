#include "benchmarks/grasp/judged_rows.h"
#include "benchmarks/reference/oracles/mujoco_trial.h"
#include "grasp/quality/hold_score.h"
#include "grasp/quality/object_mass.h"
#include "tools/grasp_cli/answers/mjcf_pieces.h"
#include "tools/grasp_cli/inputs/table_under.h"
#include "tools/grasp_cli/plan/plan_run.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::TrialOutcome;
using grasp::TrialResult;
using nlohmann::json;

/// Protocols with a fresh start for each, all of which must be held.
struct Suite
{
    std::string name;
    std::vector<grasp::TrialProtocol> parts;
    double friction = 0.5;
    double torsion = 0.0;  ///< in MuJoCo [m]
};

/// The protocol of DexGraspBench: a force of one weight along six directions, each from the start,
/// friction 0.6 and 0.02 (torsion), held if it moves by less than 0.10 m, however it turns.
Suite dexGraspBench()
{
    Suite suite{.name = "dexgraspbench", .parts = {}, .friction = 0.6, .torsion = 0.02};
    for (const grasp::TrialPhase& phase : grasp::shippedProtocol("six").phases)
    {
        suite.parts.push_back({.name = suite.name,
                               .phases = {phase},
                               .heldWay = 0.1,
                               .heldTurn = 2.0 * std::numbers::pi});
    }
    return suite;
}

/// The force closures of a plan, best first; where a suite has a table, above that.
std::vector<grasp::Grasp> graspsFor(const Suite& suite,
                                    const tools::LoadedHand& hand,
                                    const tools::LoadedObject& object,
                                    grasp::PlannerOptions options)
{
    std::vector<tools::Obstacle> tables;
    if (suite.parts.front().start == grasp::TrialStart::Table)
    {
        tables.push_back(tools::tableUnder(object.object, options.approach.up));
        options.approach.tableTop = true;
    }
    const std::vector<RigidBody> obstacles = tools::bodiesOf(tables);
    std::vector<grasp::Grasp> grasps =
        grasp::planGrasps(hand.hand,
                          object.object,
                          options,
                          tools::closingEngine(options.engine, obstacles),
                          {.obstacles = obstacles});
    std::erase_if(grasps,
                  [](const grasp::Grasp& g) { return g.reject != grasp::RejectReason::None; });
    return grasps;
}

/// The first part that is not held, else the one in which it moved most.
template <typename Try>
json resultOf(const Suite& suite, const Try& tryPart)
{
    TrialResult worst;
    worst.outcome = TrialOutcome::Held;
    for (auto part = suite.parts.begin();
         part != suite.parts.end() && worst.outcome == TrialOutcome::Held;
         ++part)
    {
        const TrialResult result = tryPart(*part);
        if (result.slip >= worst.slip || result.outcome != TrialOutcome::Held)
        {
            worst = result;
        }
    }
    return {{"outcome", toString(worst.outcome)},
            {"reason", worst.reason},
            {"slip_m", worst.slip},
            {"turn_rad", worst.turn},
            {"penetration_m", worst.penetration.deepest}};
}

}  // namespace

json judgeTrials(const tools::LoadedHand& hand,
                 const tools::LoadedObject& object,
                 const grasp::PlannerOptions& options,
                 const TrialQuestions& questions,
                 tools::PieceStore& pieces)
{
    const double mass = grasp::massOf(object.object, options.mass).mass;
    const auto score = [&](const grasp::Grasp& g) { return holdScore(g, mass); };
    std::vector<Suite> suites{
        {"six", {grasp::shippedProtocol("six")}, options.friction, questions.torsion},
        dexGraspBench(),
        {"lift", {grasp::shippedProtocol("lift")}, options.friction, questions.torsion}};
    std::erase_if(
        suites, [&](const Suite& s) { return std::ranges::count(questions.suites, s.name) == 0; });
    json trials = json::array();
    for (const Suite& suite : suites)
    {
        const std::vector<grasp::Grasp> grasps = graspsFor(suite, hand, object, options);
        const auto scored = std::ranges::max_element(grasps, {}, score);
        for (auto at = grasps.begin(); at != grasps.end(); ++at)
        {
            if (at - grasps.begin() >= questions.best && at != scored)
            {
                continue;
            }
            const grasp::TrialOptions ours{.squeeze = {.mass = mass,
                                                       .centerOfMass = object.object.centerOfMass,
                                                       .friction = suite.friction},
                                           .skinStiffness = questions.skinStiffness,
                                           .brief = true};
            const grasp::Squeeze squeeze = grasp::squeezeOf(hand.hand, *at, ours.squeeze);
            std::unique_ptr<reference::MujocoTrials> mujoco;  // none without a squeeze
            if (squeeze.exists() && !questions.alone)
            {
                mujoco = std::make_unique<reference::MujocoTrials>(
                    hand.hand, object.object, *at, squeeze, pieces.of(hand, object));
            }
            const auto tryOurs = [&](const grasp::TrialProtocol& part)
            { return grasp::runTrial(hand.hand, object.object, *at, part, ours); };
            const auto tryTheirs = [&](const grasp::TrialProtocol& part)
            {
                return mujoco ? mujoco->run(*at, squeeze, part, mass, suite.friction, suite.torsion)
                              : TrialResult{.reason = squeeze.reason};
            };
            trials.push_back({{"suite", suite.name},
                              {"rank", at - grasps.begin() + 1},
                              {"scored_first", at == scored},
                              {"candidate", at->candidate},
                              {"epsilon", at->quality.epsilon},
                              {"largest_mass_kg", at->quality.largestMass.value_or(0.0)},
                              {"ours", resultOf(suite, tryOurs)},
                              {"mujoco", questions.alone ? json() : resultOf(suite, tryTheirs)}});
        }
    }
    return {{"mass_kg", mass}, {"trials", trials}};
}
}  // namespace bullet_ccd::benchmarks
