#include "grasp/closing/closing.h"
#include "grasp/planner/pose_noise.h"
#include "grasp/quality/exact_epsilon.h"
#include "grasp/quality/force_closure.h"
#include "grasp/quality/wrench_space.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/contact_options.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_table.h"

#include <fmt/format.h>
#include <optional>

namespace bullet_ccd::tools
{
namespace
{
struct QualityArguments
{
    RecordArguments records;
    RecordChoice choice;
    ContactArguments contacts;
    grasp::WrenchNorm norm = grasp::WrenchNorm::L1;
    std::optional<int> coneEdges;       ///< else those of the plan
    std::optional<double> torqueScale;  ///< [m]; else the object's radius
    double resolution = grasp::ExactEpsilonOptions{}.resolution;
    std::vector<double> poseNoise;  ///< [m] and [rad]; empty: none
    int trials = 50;
    bool centred = false;
    double timeLimit = 0.0;
};

/// What one grasp is worth.
struct QualityRow
{
    grasp::GraspQuality pyramids;  ///< L1
    bool closure = false;          ///< of the pyramids, by linear program
    grasp::EpsilonBounds exact;
    grasp::PoseRobustness robustness;
};

grasp::PoseRobustness robustnessOf(const QualityArguments& arguments,
                                   const GraspRecords& records,
                                   const grasp::Grasp& grasp)
{
    if (arguments.poseNoise.empty())
    {
        return {};
    }
    grasp::PlannerOptions options = records.source.run.options;
    options.centred = arguments.centred;
    return grasp::poseRobustness(records.hand.hand,
                                 records.object.object,
                                 grasp,
                                 {.position = arguments.poseNoise[0],
                                  .rotation = arguments.poseNoise[1],
                                  .trials = arguments.trials},
                                 options,
                                 grasp::kinematicClosing());
}

QualityRow qualityOf(const QualityArguments& arguments,
                     const GraspRecords& records,
                     const grasp::Grasp& grasp)
{
    const grasp::PlannerOptions& plan = records.source.run.options;
    const grasp::GraspObject& object = records.object.object;
    const grasp::ContactLaw law = contactLaw(arguments.contacts, plan);
    const double torqueScale = arguments.torqueScale.value_or(object.radius);
    const std::vector<grasp::Wrench> wrenches =
        grasp::contactWrenches(grasp.contacts,
                               object.centerOfMass,
                               {.friction = law.friction,
                                .coneEdges = arguments.coneEdges.value_or(pyramidEdges(plan)),
                                .torqueScale = torqueScale,
                                .model = law.model,
                                .torsion = law.torsion});
    return {.pyramids = grasp::wrenchSpaceQuality(wrenches, plan.forceClosureThreshold),
            .closure = grasp::isForceClosure(wrenches),
            .exact = grasp::exactEpsilon(grasp.contacts,
                                         object.centerOfMass,
                                         {.law = law,
                                          .norm = arguments.norm,
                                          .torqueScale = torqueScale,
                                          .resolution = arguments.resolution}),
            .robustness = robustnessOf(arguments, records, grasp)};
}

/// Share of the trials, and epsilon in the median.
std::vector<std::string> robustnessCells(const QualityArguments& arguments, const QualityRow& row)
{
    if (arguments.poseNoise.empty())
    {
        return {};
    }
    const grasp::PoseRobustness& robustness = row.robustness;
    return {fmt::format("{} of {}", robustness.forceClosures, robustness.trials),
            fmt::format("{}", robustness.sameLinks),
            fmt::format("{:.6f}", robustness.medianEpsilon())};
}

int quality(const QualityArguments& arguments)
{
    const GraspRecords records = loadGraspRecords(arguments.records);
    TextTable table{.header = {"rank",
                               "candidate",
                               "contacts",
                               "recorded epsilon",
                               "pyramids L1",
                               "volume",
                               "cones, from",
                               "to",
                               "force closure"},
                    .rows = {}};
    if (!arguments.poseNoise.empty())
    {
        table.header.insert(table.header.end(),
                            {"held under noise", "by the same links", "median epsilon"});
    }
    const std::vector<std::size_t> chosen =
        chosenGrasps(records, arguments.records, arguments.choice);
    const StopRequest stop(arguments.timeLimit);
    std::size_t done = 0;
    int closures = 0;
    for (; done < chosen.size() && !stop.isDue(); ++done)
    {
        const std::size_t index = chosen[done];
        const grasp::Grasp& grasp = records.grasps[index];
        const QualityRow row = qualityOf(arguments, records, grasp);
        const bool closure = row.closure || row.exact.forceClosure();
        closures += closure ? 1 : 0;
        table.rows.push_back({fmt::format("{}", records.ranks[index]),
                              fmt::format("{}", grasp.candidate),
                              fmt::format("{}", grasp.contacts.size()),
                              fmt::format("{:.6f}", grasp.quality.epsilon),
                              fmt::format("{:.6f}", row.pyramids.epsilon),
                              fmt::format("{:.4g}", row.pyramids.volume),
                              fmt::format("{:.6f}", row.exact.lower),
                              fmt::format("{:.6f}", row.exact.upper),
                              closure ? "yes" : "no"});
        const std::vector<std::string> cells = robustnessCells(arguments, row);
        table.rows.back().insert(table.rows.back().end(), cells.begin(), cells.end());
    }
    fmt::print("{}\n{} of {} grasps are force closures\n", alignedText(table), closures, done);
    return stop.finish("grasp quality",
                       done,
                       chosen.size(),
                       "grasps",
                       records.exitCode(closures > 0 ? kDone : kNothingFound));
}
}  // namespace

void addQualityCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "quality",
        "Computes epsilon, volume and force closure of planned grasps under other assumptions.");
    command->footer(
        "The columns 'pyramids L1' and 'volume' are those of inscribed pyramids and normal forces "
        "that sum to 1 (qhull). The columns 'cones' are bounds of epsilon for exact cones in the "
        "chosen norm, at most --resolution apart. Wrenches are about the centre of mass.\n"
        "\n"
        "Exit codes: 0 if a chosen grasp is a force closure, 1 if none is, 130 after Ctrl-C, 2 for "
        "wrong options, 3 "
        "for "
        "bad input.\n"
        "\n"
        "Example:\n"
        "  grasp quality out/grasps.jsonl --model soft --friction 0.8 \\\n"
        "      --pose-noise 0.002 0.02");
    const auto arguments = std::make_shared<QualityArguments>();
    addRecordOptions(*command, arguments->records);
    addChoiceOptions(*command, arguments->choice);
    addContactOptions(*command, arguments->contacts);
    command
        ->add_option(
            "--cone-edges",
            arguments->coneEdges,
            "The number of edges of the friction pyramids. Default: that of the plan, or 8 if it "
            "took exact cones.")
        ->type_name("N")
        ->check(within(3, 64))
        ->group("Method");
    command
        ->add_option("--norm",
                     arguments->norm,
                     "What the normal forces of the cones may be. l1: their sum is at most 1. "
                     "linf: each is at most 1.")
        ->type_name("NORM")
        ->transform(wordFor<grasp::WrenchNorm>(
            {{"l1", grasp::WrenchNorm::L1}, {"linf", grasp::WrenchNorm::LInfinity}}))
        ->default_str("l1")
        ->group("Method");
    command
        ->add_option(
            "--torque-scale",
            arguments->torqueScale,
            "The length that moments are divided by [m]. Default: the radius of the object.")
        ->type_name("M")
        ->check(within(1e-9, 1e9))
        ->group("Method");
    // --tolerance is its name of before.
    command
        ->add_option("--resolution,--tolerance",
                     arguments->resolution,
                     "How far apart the bounds of epsilon may be.")
        ->type_name("R")
        ->check(within(1e-10, 1.0))
        ->capture_default_str()
        ->group("Method");
    command
        ->add_option("--pose-noise",
                     arguments->poseNoise,
                     "Repeat every grasp with the object off by normal errors of these standard "
                     "deviations: along "
                     "each axis [m], and of the rotation vector [rad].")
        ->type_name("M RAD")
        ->expected(2)
        ->check(within(0.0, 10.0))
        ->group("Robustness");
    command
        ->add_option(
            "--trials", arguments->trials, "With --pose-noise: how often to repeat each grasp.")
        ->type_name("N")
        ->check(within(1, 1'000'000))
        ->capture_default_str()
        ->group("Robustness");
    command
        ->add_flag("--centred",
                   arguments->centred,
                   "With --pose-noise: jaws on one motor that touch on one side go sideways.")
        ->group("Robustness");
    addTimeLimitOption(*command, arguments->timeLimit, "Take no further grasp");
    command->callback([arguments, &exitCode] { exitCode = quality(*arguments); });
}
}  // namespace bullet_ccd::tools
