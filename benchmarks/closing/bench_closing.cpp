/// Contact finding of a grasp (approach and closing): ours against the discrete baseline.
#include "benchmarks/closing/closing_run.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/hand/hand_file.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <optional>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::benchmarks;
namespace fs = std::filesystem;

struct Arguments
{
    fs::path data = BULLET_CCD_BENCHMARK_DATA;
    std::vector<std::string> hands{"schunk_sah/schunk_sah_right_mesh",
                                   "allegro/allegro_right_mesh",
                                   "barrett/barrett_mesh",
                                   "shadow/shadow_right_mesh",
                                   "schunk_svh/schunk_svh_right_mesh",
                                   "leap/leap_right_mesh",
                                   "panda_gripper/panda_gripper_mesh",
                                   "schunk_sdh/schunk_sdh_mesh"};
    std::vector<std::string> objects{
        "ycb_16k/025_mug.obj", "ycb_16k/006_mustard_bottle.obj", "ycb_16k/035_power_drill.obj"};
    int candidates = 20;
    std::uint64_t seed = 1;
    int clutter = 0;
    bool onlyOurs = false;
    std::string csv;
};

/// What one pair of hand and object says about speed and accuracy.
struct Row
{
    std::string hand;
    std::string object;
    ClosingComparison comparison;
    double fclRatio = 0.0;   // of the peer at its default to ours; 0 without the peer
    double bestRatio = 0.0;  // of the baseline on our trees, at its fastest step, to ours
    std::string bestStep;
};

Row rowOf(const std::string& hand, const std::string& object, ClosingComparison comparison)
{
    Row row{.hand = hand, .object = object, .comparison = std::move(comparison), .bestStep = {}};
    const std::vector<MethodResult>& methods = row.comparison.methods;
    const double ours = methods.front().meanMicroseconds;
    for (const MethodResult& method : methods)
    {
        const double ratio = method.meanMicroseconds / ours;
        if (method.name.starts_with("FCL"))
        {
            row.fclRatio = ratio;
        }
        else if (method.name.starts_with("own") && (row.bestStep.empty() || ratio < row.bestRatio))
        {
            row.bestRatio = ratio;
            row.bestStep = method.name;
        }
    }
    return row;
}

void print(const Row& row)
{
    fmt::print("\n{} x {}: {} candidates\n", row.hand, row.object, row.comparison.candidates);
    for (const MethodResult& method : row.comparison.methods)
    {
        fmt::print("  {:<22} {:10.1f} us {:8.2f} x ours   other posture than the sweep: {}\n",
                   method.name,
                   method.meanMicroseconds,
                   method.meanMicroseconds / row.comparison.methods.front().meanMicroseconds,
                   method.otherPosture);
    }
    const std::vector<ClosingOutcome>& ours = row.comparison.methods.front().outcomes;
    double queries = 0.0;
    ArticulatedCounters counters;
    for (const ClosingOutcome& outcome : ours)
    {
        queries += static_cast<double>(outcome.closing.steps);
        counters += outcome.closing.counters;
    }
    const double count = static_cast<double>(std::max<std::size_t>(1, ours.size()));
    const auto share = [&](std::int64_t culled)
    {
        return 100.0 * static_cast<double>(culled) /
               static_cast<double>(std::max<std::int64_t>(1, counters.pairs));
    };
    fmt::print(
        "  ours, a closing: {:.1f} queries, {:.1f} pairs of links and objects ({:.0f} % culled "
        "by space, {:.0f} % by time), {:.0f} node and {:.0f} triangle pairs, {:.0f} states\n",
        queries / count,
        static_cast<double>(counters.pairs) / count,
        share(counters.culledBySpace),
        share(counters.culledByTime),
        static_cast<double>(counters.nodePairs) / count,
        static_cast<double>(counters.trianglePairs) / count,
        static_cast<double>(counters.states) / count);
    std::fflush(stdout);
}

void write(std::ostream& csv, const Row& row)
{
    for (const MethodResult& method : row.comparison.methods)
    {
        for (std::size_t i = 0; i < method.outcomes.size(); ++i)
        {
            csv << fmt::format("{},{},{},{},{:.3f},{}\n",
                               row.hand,
                               row.object,
                               i,
                               method.name,
                               method.outcomes[i].microseconds,
                               method.outcomes[i].closing.stops.size());
        }
    }
}

void summarize(const std::vector<Row>& rows)
{
    std::vector<double> best;
    double fclSum = 0.0;
    double fclLeast = INFINITY;
    int candidates = 0;
    int other = 0;
    double worst = 0.0;
    for (const Row& row : rows)
    {
        worst = std::max(worst, row.comparison.worstOther);
        best.push_back(row.bestRatio);
        fclSum += row.fclRatio;
        fclLeast = std::min(fclLeast, row.fclRatio);
        candidates += row.comparison.candidates;
        other += row.comparison.oursOther;
    }
    fmt::print("\n{} pairs, {} candidates\n", rows.size(), candidates);
    if (isFclPresent())
    {
        fmt::print("baseline at default steps with {}: {:.1f} x ours in the mean, least {:.1f}\n",
                   fclVersion(),
                   fclSum / static_cast<double>(rows.size()),
                   fclLeast);
    }
    fmt::print(
        "baseline at its fastest step on our trees: {:.1f} x ours in the median, least {:.1f}\n",
        medianOf(best),
        *std::min_element(best.begin(), best.end()));
    fmt::print(
        "ours in another posture than the sweep of 0.001 rad: {} of {}, farthest by {:.4f} rad\n",
        other,
        candidates,
        worst);
}

int run(const Arguments& arguments)
{
    std::ofstream csv;
    if (!arguments.csv.empty())
    {
        csv.open(arguments.csv);
        csv << "hand,object,candidate,method,microseconds,links_stopped\n";
    }
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
                                    .seed = arguments.seed,
                                    .clutter = arguments.clutter};
            rows.push_back(rowOf(
                name, file, compareClosing(scene, arguments.onlyOurs ? Peers::None : Peers::All)));
            print(rows.back());
            write(csv, rows.back());
        }
    }
    if (!arguments.onlyOurs)
    {
        summarize(rows);
    }
    return 0;
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Approach and closing of hands on objects: ours against stepping and bisection."};
    Arguments arguments;
    app.add_option("--data", arguments.data, "folder with hands/ and objects/")
        ->capture_default_str();
    app.add_option("--hands", arguments.hands, "URDF files below hands/, without their ending");
    app.add_option("--objects", arguments.objects, "files below objects/");
    app.add_option("-n,--candidates", arguments.candidates, "of each hand with each object")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    app.add_option("--seed", arguments.seed, "of the candidates")->capture_default_str();
    app.add_option(
           "--clutter", arguments.clutter, "objects out of reach beside the one that ours grasps")
        ->check(CLI::Range(0, 10'000));
    app.add_flag("--only-ours", arguments.onlyOurs, "to count its instructions: no other method");
    app.add_option("--csv", arguments.csv, "file for one line a candidate and method");
    CLI11_PARSE(app, argc, argv);
    try
    {
        return run(arguments);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "bench_closing: %s\n", error.what());
        return 3;
    }
}
