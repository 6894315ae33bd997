// Contact finding of a grasp (approach and closing): ours against the discrete baseline.
#include "benchmarks/closing/closing_run.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/counters.h"
#include "benchmarks/support/files.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/hand/hand_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::ClosingResult;

/// Of the steps on our hierarchies.
constexpr std::array kFactors{1.0, 2.5, 5.0, 10.0, 20.0};

/// Hands whose collision geometry is the detailed mesh, polygon soups with cracks and all: URDF
/// files below hands/ of the data folder, without their ending.
constexpr std::array kDetailedHands{"allegro/allegro_right_mesh",
                                    "barrett/barrett_mesh",
                                    "leap/leap_right_mesh",
                                    "panda_gripper/panda_gripper_mesh",
                                    "schunk_sah/schunk_sah_right_mesh",
                                    "schunk_sdh/schunk_sdh_mesh",
                                    "schunk_svh/schunk_svh_right_mesh",
                                    "shadow/shadow_right_mesh"};

struct Arguments
{
    std::filesystem::path data = defaultDataFolder();
    std::vector<std::string> hands{kDetailedHands.begin(), kDetailedHands.end()};
    std::vector<std::string> objects{
        "ycb_16k/025_mug.obj", "ycb_16k/006_mustard_bottle.obj", "ycb_16k/035_power_drill.obj"};
    int candidates = 20;
    std::uint64_t seed = 1;
    double accuracy = kClosingTolerance;
    bool onlyOurs = false;
};

/// A method over all candidates.
struct MethodResult
{
    std::string name;
    std::vector<ClosingOutcome> outcomes;  ///< one a candidate
    double meanMicroseconds = 0.0;
    /// Candidates of which a joint ends more than kSamePosture from the reference.
    int otherPosture = 0;
};

/// Of one hand and object; candidates whose approach meets nothing are left out of all.
struct ClosingComparison
{
    int candidates = 0;
    std::vector<MethodResult> methods;  ///< ours first, then the baselines
    int oursOther = 0;                  ///< ours against the fine sweep
    double worstOther = 0.0;            ///< by so much [rad or m]
};

/// Ours (continuous), the discrete baseline on FCL and on the project's own hierarchies at the
/// default step and at larger ones, and, for the posture, a sweep of 0.001 rad.
///
/// Every method makes its own approach; all close from where ours ended, so that the postures can
/// be compared.
/// @param withPeers  otherwise ours alone, and no reference
ClosingComparison compareClosing(const ClosingCase& scene, double accuracy, bool withPeers)
{
    const std::vector<ClosingStart> starts = closingStarts(scene);
    ClosingComparison comparison{.candidates = static_cast<int>(starts.size()), .methods = {}};
    const auto add = [&](std::string name, const RunClosing& run)
    {
        MethodResult method{.name = std::move(name), .outcomes = {}};
        std::vector<double> micros;
        for (const ClosingStart& start : starts)
        {
            method.outcomes.push_back(run(start));
            micros.push_back(method.outcomes.back().microseconds);
        }
        method.meanMicroseconds = meanOf(micros);
        comparison.methods.push_back(std::move(method));
    };
    add("ours", runContinuous(scene, accuracy));
    if (!withPeers)
    {
        return comparison;
    }
    const std::unique_ptr<LinkProximity> fcl = fclProximity(scene.hand, scene.object);
    add("FCL, default step", runDiscrete(*fcl, scene.hand, {}));
    const std::unique_ptr<LinkProximity> trees = treeProximity(scene.hand, scene.object);
    for (const double factor : kFactors)
    {
        const DiscreteOptions options{.closingStep = 0.01 * factor};
        add(fmt::format("own trees, step x {:g}", factor),
            runDiscrete(*trees, scene.hand, options));
    }
    const DiscreteOptions fine{
        .closingStep = 0.001, .contactGap = kClosingTolerance, .maxSteps = 100'000};
    for (std::size_t i = 0; i < starts.size(); ++i)
    {
        const ClosingResult reference =
            discreteClosing(*trees, scene.hand, starts[i].X_WH, starts[i].open, fine);
        for (MethodResult& method : comparison.methods)
        {
            const double by = postureDifference(
                scene.hand, method.outcomes[i].closing.positions, reference.positions);
            method.otherPosture += by > kSamePosture ? 1 : 0;
            if (&method == comparison.methods.data())
            {
                comparison.worstOther = std::max(comparison.worstOther, by);
            }
        }
    }
    comparison.oursOther = comparison.methods.front().otherPosture;
    return comparison;
}

/// One pair of hand and object.
struct Row
{
    std::string hand;
    std::string object;
    ClosingComparison comparison;

    [[nodiscard]] double ours() const { return comparison.methods.front().meanMicroseconds; }
    /// Time of the fastest of the methods whose names begin so, as a multiple of ours; 0 for none.
    [[nodiscard]] double ratioOf(const std::string& beginning) const
    {
        double least = INFINITY;
        for (const MethodResult& method : comparison.methods)
        {
            if (method.name.starts_with(beginning))
            {
                least = std::min(least, method.meanMicroseconds / ours());
            }
        }
        return std::isinf(least) ? 0.0 : least;
    }
};

void print(const Row& row)
{
    fmt::print("\n{} x {}: {} candidates\n", row.hand, row.object, row.comparison.candidates);
    const Table table(
        "method:<22|us:>10.1f|x ours=ratio:>8.2f|other posture than the sweep=other:>28");
    for (const MethodResult& method : row.comparison.methods)
    {
        table.print({{"method", method.name},
                     {"us", method.meanMicroseconds},
                     {"ratio", method.meanMicroseconds / row.ours()},
                     {"other", method.otherPosture}});
    }
    const std::vector<ClosingOutcome>& ours = row.comparison.methods.front().outcomes;
    double queries = 0.0;
    ArticulatedCounters counters;
    for (const ClosingOutcome& outcome : ours)
    {
        queries += static_cast<double>(outcome.closing.steps);
        counters += outcome.closing.counters;
    }
    const double closings = std::max(1.0, static_cast<double>(ours.size()));
    nlohmann::json work = rowOf(counters, closings);
    work["queries"] = queries / closings;
    Table(fmt::format("per closing of ours, queries=queries:>29.1f|{}", kCounterColumns))
        .print(work);
}

void summarize(const std::vector<Row>& rows)
{
    std::vector<double> best;
    std::vector<double> fcl;
    int candidates = 0;
    int other = 0;
    double worst = 0.0;
    for (const Row& row : rows)
    {
        worst = std::max(worst, row.comparison.worstOther);
        best.push_back(row.ratioOf("own"));
        fcl.push_back(row.ratioOf("FCL"));
        candidates += row.comparison.candidates;
        other += row.comparison.oursOther;
    }
    fmt::print("\n{} pairs, {} candidates\n", rows.size(), candidates);
    fmt::print("baseline at default steps with {}: {:.1f} x ours in the mean, least {:.1f}\n",
               fclVersion(),
               meanOf(fcl),
               std::ranges::min(fcl));
    fmt::print(
        "baseline at its fastest step on our trees: {:.1f} x ours in the median, least {:.1f}\n",
        medianOf(best),
        std::ranges::min(best));
    fmt::print(
        "ours in another posture than the sweep of 0.001 rad: {} of {}, farthest by {:.4f} rad\n",
        other,
        candidates,
        worst);
}

bool run(const Arguments& arguments)
{
    std::vector<Row> rows;
    for (const std::string& name : arguments.hands)
    {
        const grasp::HandModel hand = grasp::loadHand(
            arguments.data / "hands" / (name + ".urdf"), std::nullopt, BULLET_CCD_SHARE);
        for (const std::string& file : arguments.objects)
        {
            const grasp::GraspObject object =
                grasp::makeGraspObject(file, loadMeshFile(arguments.data / "objects" / file).mesh);
            const ClosingCase scene{.hand = hand,
                                    .object = object,
                                    .candidates = arguments.candidates,
                                    .seed = arguments.seed};
            rows.push_back(
                {name, file, compareClosing(scene, arguments.accuracy, !arguments.onlyOurs)});
            print(rows.back());
        }
    }
    if (!arguments.onlyOurs)
    {
        summarize(rows);
    }
    return true;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    Arguments arguments;
    return runProgram(
        argc,
        argv,
        {.name = "bench_closing",
         .about = "Approach and closing of hands on objects: ours against stepping and bisection.",
         .options = {{"--data", &arguments.data, "folder with hands/ and objects/"},
                     {"--hands", &arguments.hands, "URDF files below hands/, without their ending"},
                     {"--objects", &arguments.objects, "files below objects/"},
                     {"-n,--candidates", &arguments.candidates, "of each hand with each object"},
                     {"--seed", &arguments.seed, "of the candidates"},
                     {"--accuracy", &arguments.accuracy, "tolerance of ours [m]"},
                     {"--only-ours",
                      &arguments.onlyOurs,
                      "to count its instructions: no other method"}},
         .run = [&] { return run(arguments); }});
}
