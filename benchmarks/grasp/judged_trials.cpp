#include "benchmarks/grasp/judged_rows.h"
#include "benchmarks/reference/oracles/mujoco_trial.h"
#include "grasp/quality/object_mass.h"
#include "tools/grasp_cli/answers/mjcf_pieces.h"
#include "tools/grasp_cli/plan/plan_run.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::TrialOutcome;
using grasp::TrialResult;
using nlohmann::json;
using Rows = std::vector<json>;

constexpr double kAgreement = 0.9;
const std::string kAll = "all";
// Of MuJoCo's models; hands have many links.
constexpr ConvexPiecesOptions kPieces{.accuracy = 1e-3, .most = 64};

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

/// How many, held by ours, by MuJoCo, and of whom both say the same.
using Tally = std::array<int, 4>;

bool isHeld(const json& trial, const char* engine)
{
    return trial[engine]["outcome"] == "held";
}

void add(Tally& tally, const json& trial)
{
    const bool ours = isHeld(trial, "ours");
    const bool theirs = isHeld(trial, "mujoco");
    tally[0] += 1;
    tally[1] += ours ? 1 : 0;
    tally[2] += theirs ? 1 : 0;
    tally[3] += ours == theirs ? 1 : 0;
}

std::string text(const json& one)
{
    return fmt::format("{} {:.1f} mm {:.0f} degrees {}",
                       one["outcome"].get<std::string>(),
                       1e3 * one["slip_m"].get<double>(),
                       one["turn_rad"].get<double>() * 180.0 / std::numbers::pi,
                       one["reason"].get<std::string>());
}

std::string wordOf(const json& trial, const char* engine)
{
    return trial[engine]["outcome"].get<std::string>();
}
}  // namespace

json judgeTrials(const tools::LoadedHand& hand,
                 const tools::LoadedObject& object,
                 const grasp::PlannerOptions& options,
                 int best)
{
    std::vector<grasp::Grasp> grasps =
        grasp::planGrasps(hand.hand, object.object, options, tools::closingEngine(options.engine));
    std::erase_if(grasps,
                  [](const grasp::Grasp& g) { return g.reject != grasp::RejectReason::None; });
    grasps.resize(std::min(grasps.size(), static_cast<std::size_t>(best)));
    const double mass = grasp::massOf(object.object, options.mass).mass;
    const std::vector<Suite> suites{
        {.name = "six", .parts = {grasp::shippedProtocol("six")}, .friction = options.friction},
        dexGraspBench()};
    json trials = json::array();
    std::unique_ptr<reference::MujocoTrials> mujoco;
    for (const grasp::Grasp& grasp : grasps)
    {
        for (const Suite& suite : suites)
        {
            const grasp::TrialOptions ours{.squeeze = {.mass = mass,
                                                       .centerOfMass = object.object.centerOfMass,
                                                       .friction = suite.friction}};
            const grasp::Squeeze squeeze = grasp::squeezeOf(hand.hand, grasp, ours.squeeze);
            if (!mujoco)
            {
                mujoco = std::make_unique<reference::MujocoTrials>(
                    hand.hand,
                    object.object,
                    grasp,
                    squeeze,
                    tools::piecesOf(hand.hand, object.object, kPieces));
            }
            const auto tryOurs = [&](const grasp::TrialProtocol& part)
            { return grasp::runTrial(hand.hand, object.object, grasp, part, ours); };
            const auto tryTheirs = [&](const grasp::TrialProtocol& part)
            { return mujoco->run(grasp, squeeze, part, mass, suite.friction, suite.torsion); };
            trials.push_back({{"suite", suite.name},
                              {"rank", &grasp - grasps.data() + 1},
                              {"candidate", grasp.candidate},
                              {"epsilon", grasp.quality.epsilon},
                              {"mass_kg", mass},
                              {"ours", resultOf(suite, tryOurs)},
                              {"mujoco", resultOf(suite, tryTheirs)}});
        }
    }
    return {{"trials", trials}};
}

bool summarizeTrials(const Rows& rows)
{
    std::map<std::string, Tally> tallies;  // by protocol and what they are of
    std::map<std::string, int> classes;
    double deepest = 0.0;
    for (const json& row : rows)
    {
        for (const json& trial : row["trials"])
        {
            const std::string suite = trial["suite"];
            const std::string hand = row["hand"];
            const std::string object = row["object"];
            for (const std::string& of : {"hand " + hand, "object " + object, kAll})
            {
                add(tallies[suite + ", " + of], trial);
            }
            if (trial["rank"] == 1)
            {
                add(tallies[suite + ", rank 1"], trial);
            }
            deepest = std::max(deepest, trial["ours"]["penetration_m"].get<double>());
            if (isHeld(trial, "ours") != isHeld(trial, "mujoco"))
            {
                ++classes[suite + ": ours " + wordOf(trial, "ours") + ", MuJoCo " +
                          wordOf(trial, "mujoco")];
                fmt::print("differ: {}, {}, {}, candidate {}: ours {} | MuJoCo {}\n",
                           suite,
                           hand,
                           object,
                           trial["candidate"].get<long>(),
                           text(trial["ours"]),
                           text(trial["mujoco"]));
            }
        }
    }
    bool isGood = true;
    for (const auto& [name, tally] : tallies)
    {
        const double one = 0.01 * tally[0];
        fmt::print("{:<50} {:5} grasps, held: ours {:5.1f} %, MuJoCo {:5.1f} %, agree {:5.1f} %\n",
                   name,
                   tally[0],
                   tally[1] / one,
                   tally[2] / one,
                   tally[3] / one);
        isGood = isGood && (!name.ends_with(kAll) || tally[3] >= kAgreement * tally[0]);
    }
    for (const auto& [name, count] : classes)
    {
        fmt::print("differ: {}: {}\n", name, count);
    }
    fmt::print("deepest penetration of ours: {:g} mm\n", 1e3 * deepest);
    return isGood;
}
}  // namespace bullet_ccd::benchmarks
