#include "grasp/formats/content_hash.h"
#include "grasp/quality/hold_score.h"
#include "grasp/quality/object_mass.h"
#include "grasp/report/report_facts.h"
#include "grasp/task/arm_kinematics.h"
#include "tools/grasp_cli/answers/plan_trials.h"
#include "tools/grasp_cli/answers/trial_runs.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/inputs/table_under.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/grasp_cli/options/planner_options.h"
#include "tools/grasp_cli/options/robot_options.h"
#include "tools/grasp_cli/options/squeeze_options.h"
#include "tools/grasp_cli/plan/plan_advice.h"
#include "tools/grasp_cli/plan/plan_journal.h"
#include "tools/grasp_cli/plan/plan_outputs.h"
#include "tools/grasp_cli/plan/plan_run.h"
#include "tools/support/obstacles/obstacle_list.h"
#include "tools/support/progress_line.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::Grasp;
using grasp::RejectReason;

struct PlanArguments
{
    PairOptions pair;
    fs::path output = "out";
    DrawingOptions drawing;
    bool quiet = false;
    bool resume = false;
    std::vector<std::string> scene;
    SqueezeArguments squeeze;
    PlanTrials trials;
    std::string rank = "epsilon";
    RobotArguments robot;   // its arm: --robot; empty: the hand may be anywhere
    std::string robotPose;  // empty: the identity
    grasp::PlannerOptions options;
};

/// Which poses of the hand in the object the arm reaches; nothing without an arm.
std::function<bool(const Eigen::Isometry3d&)> reachOf(const PlanArguments& arguments,
                                                      const grasp::HandModel& hand)
{
    if (arguments.robot.arm.empty())
    {
        return {};
    }
    const grasp::ArmRobot robot = mountedOn(arguments.robot, hand);
    const auto arm = std::make_shared<const grasp::ArmKinematics>(
        robot.tree,
        robot.handRoot,
        arguments.robotPose.empty() ? Eigen::Isometry3d::Identity()
                                    : poseFromText(arguments.robotPose));
    return [arm, start = grasp::startPositions(robot, {})](const Eigen::Isometry3d& X_OH)
    { return !arm->solve(X_OH, start, {.wanted = 1}).empty(); };
}

/// As records keep it: what the reach depends on.
std::string robotText(const PlanArguments& arguments)
{
    const RobotArguments& robot = arguments.robot;
    return robot.arm.empty() ? std::string()
                             : fmt::format("{} at {}, flange {}, mount {}",
                                           robot.arm,
                                           arguments.robotPose.empty() ? "0" : arguments.robotPose,
                                           robot.flange.empty() ? "default" : robot.flange,
                                           robot.mount.empty() ? "0" : robot.mount);
}

/// The largest mass that the grasp holds in any direction.
std::string massText(const Grasp& grasp)
{
    const std::optional<double>& mass = grasp.quality.largestMass;
    return !mass ? "-" : std::isinf(*mass) ? "any" : fmt::format("{:.3g}", *mass);
}

/// How many force closures hold the weight of the object, whichever way it pulls.
std::string weightText(const std::vector<Grasp>& grasps, const grasp::ObjectMass& mass)
{
    const auto holds = [&](double factor)
    {
        return std::ranges::count_if(grasps,
                                     [&](const Grasp& grasp)
                                     {
                                         return grasp.reject == RejectReason::None &&
                                                grasp.quality.largestMass.value_or(0.0) >=
                                                    factor * mass.mass;
                                     });
    };
    return fmt::format(
        "{} of {} hold {} in any direction within the efforts, {} twice that (--mass)",
        holds(1.0),
        forceClosures(grasps),
        massText(mass),
        holds(2.0));
}

/// Ranks the force closures by how likely they are to hold the object.
void rankByScore(PlanRun& run, const std::optional<double>& given)
{
    const double mass = grasp::massOf(run.object.object, given).mass;
    std::map<std::int64_t, double> scores;
    const auto count = static_cast<std::ptrdiff_t>(forceClosures(run.grasps));
    for (const Grasp& grasp : std::span(run.grasps).first(static_cast<std::size_t>(count)))
    {
        scores[grasp.candidate] = grasp::holdScore(grasp, mass);
    }
    std::stable_sort(run.grasps.begin(),
                     run.grasps.begin() + count,
                     [&](const Grasp& a, const Grasp& b)
                     { return scores[a.candidate] > scores[b.candidate]; });
}

/// Such as "lift held, six slipped"; empty for a grasp that was not tried.
std::string trialText(const grasp::GraspRun& description, const Grasp& grasp)
{
    const auto found = description.trials.find(grasp.candidate);
    std::vector<std::string> texts;
    if (found != description.trials.end())
    {
        for (const grasp::TrialNote& note : found->second)
        {
            texts.push_back(note.protocol + " " + note.outcome);
        }
    }
    return joined(texts, ", ");
}

std::string bestGrasps(const grasp::GraspRun& description,
                       const std::vector<Grasp>& grasps,
                       std::size_t rows)
{
    TextTable table{.header = {"rank",
                               "candidate",
                               "epsilon",
                               "holds [kg]",
                               "volume",
                               "contacts",
                               "links",
                               "preshape",
                               "back off [mm]"},
                    .rows = {}};
    if (!description.trials.empty())
    {
        table.header.emplace_back("trials");
    }
    for (std::size_t k = 0; k < std::min(rows, grasps.size()); ++k)
    {
        const Grasp& g = grasps[k];
        if (g.reject != RejectReason::None)
        {
            break;
        }
        const double along = (g.X_WH.translation() - g.X_WStart.translation()).dot(g.approach_W);
        table.rows.push_back(
            {fmt::format("{}", k + 1),
             fmt::format("{}", g.candidate),
             fmt::format("{:.4f}", g.quality.epsilon),
             massText(g),
             g.quality.volume > 0.0 ? fmt::format("{:.3g}", g.quality.volume) : "-",
             fmt::format("{}", g.contacts.size()),
             fmt::format("{}", linksInContact(g)),
             g.preshape,
             fmt::format("{:.1f}", 1e3 * std::max(0.0, g.approachDistance - along))});
        if (!description.trials.empty())
        {
            table.rows.back().push_back(trialText(description, g));
        }
    }
    return alignedText(table);
}

/// What the swept boxes of the hand were worth.
std::string cullingText(const std::vector<Grasp>& grasps, std::size_t obstacles)
{
    double near = 0.0;
    for (const Grasp& grasp : grasps)
    {
        near += static_cast<double>(grasp.obstaclesInReach);
    }
    near /= std::max(1.0, static_cast<double>(grasps.size()));
    return fmt::format(
        "obstacles: {}, of which {:.1f} in reach of a candidate ({:.1f} % culled by swept boxes)\n",
        obstacles,
        near,
        100.0 * (1.0 - near / static_cast<double>(obstacles)));
}

void printSummary(const PlanArguments& arguments,
                  const PlanRun& run,
                  const grasp::GraspRun& description,
                  const std::vector<Obstacle>& obstacles,
                  bool wasInterrupted,
                  const std::vector<std::string>& written)
{
    constexpr std::size_t kRows = 10;
    const std::size_t found = forceClosures(run.grasps);
    fmt::print("{} x {}: {} of {} candidates are force closures (mu {:g}, epsilon >= {:g})\n",
               run.hand.hand.robot.name,
               run.object.object.name,
               found,
               run.grasps.size(),
               arguments.options.friction,
               arguments.options.forceClosureThreshold);
    if (const std::string left = candidatesLeft(run.grasps, arguments.options.candidates);
        !left.empty())
    {
        fmt::print("{}: {} of {} candidates tried, not {}; --resume goes on with them\n",
                   wasInterrupted ? "interrupted" : "time limit reached",
                   run.grasps.size(),
                   arguments.options.candidates,
                   left);
    }
    if (found > 0)
    {
        fmt::print(
            "{}\n{}\n",
            epsilonClasses(run.grasps),
            weightText(run.grasps, grasp::massOf(run.object.object, arguments.options.mass)));
        if (const std::string assumed = assumedEfforts(*description.squeeze, run.hand.hand);
            !assumed.empty())
        {
            fmt::print(
                "efforts assumed, since the robot states none that a finger has (--effort "
                "sets them): {}\n",
                assumed);
        }
        fmt::print("\n{}", bestGrasps(description, run.grasps, kRows));
        if (found > kRows)
        {
            fmt::print("({} more in the files)\n", found - kRows);
        }
    }
    fmt::print("\n");
    for (const auto& [name, key] :
         {std::pair("sources", &Grasp::source), std::pair("preshapes", &Grasp::preshape)})
    {
        fmt::print("{}: {}\n", name, grasp::sharesText(run.grasps, key));
    }
    if (const std::string rejected = rejectionCounts(run.grasps); !rejected.empty())
    {
        fmt::print("rejected: {}\n", rejected);
    }
    if (const std::string advice = planAdvice(
            run.hand.hand, run.object.object, run.grasps, arguments.options.approach.tableTop);
        !advice.empty())
    {
        fmt::print("look at: {}\n", advice);
    }
    if (!obstacles.empty())
    {
        fmt::print("{}", cullingText(run.grasps, obstacles.size()));
    }
    if (!run.uses.empty())
    {
        fmt::print("closing needed {}\n",
                   plainText(closingShare(
                       run.uses, run.hand.hand, run.object.object, {.inReach = obstacles})));
    }
    fmt::print("planned in {:.2f} s, {:.0f} candidates a second\nwritten:  {}\n",
               run.seconds,
               static_cast<double>(run.grasps.size()) / std::max(run.seconds, 1e-9),
               joined(written, "\n          "));
}

void printNotes(const PlanJournal& journal, const PlanArguments& arguments)
{
    const std::string file = journal.file().string();
    if (!journal.known().empty())
    {
        fmt::print(stderr,
                   "{}: {} of {} candidates were tried before and are taken over\n",
                   file,
                   journal.known().size(),
                   arguments.options.candidates);
    }
    else if (arguments.resume)
    {
        fmt::print(stderr, "{}: no stopped run here: starting at the first candidate\n", file);
    }
    else if (!journal.setAside().empty())
    {
        fmt::print(stderr,
                   "{}: of a stopped run that --resume would have gone on with: now {}\n",
                   file,
                   journal.setAside().filename().string());
    }
}

int plan(PlanArguments arguments)
{
    setAccuracyOfScenes(arguments.options.closing, arguments.scene);
    PlanRun run{.hand = loadHandOf(arguments.pair), .object = loadObjectOf(arguments.pair)};
    const grasp::HandModel& hand = run.hand.hand;
    const grasp::GraspObject& object = run.object.object;
    requireFingers(run.hand, arguments.options.closing);
    std::vector<Obstacle> obstacles = loadObstacles(arguments.scene);
    if (arguments.options.approach.tableTop)
    {
        obstacles.push_back(tableUnder(object, arguments.options.approach.up));
    }
    requireKinematic(obstacles, arguments.options);
    const std::vector<RigidBody> bodies = bodiesOf(obstacles);
    SqueezeArguments squeeze = arguments.squeeze;
    squeeze.mass = grasp::massOf(object, arguments.options.mass).mass;
    grasp::PlannerOptions options = arguments.options;
    grasp::GraspRun description{.handFile = run.hand.file,
                                .srdfFile = hand.srdfFile,
                                .objectFile = run.object.file,
                                .objectScale = arguments.pair.objectScale,
                                .obstaclesHash = grasp::contentHash(bodies),
                                .robot = robotText(arguments),
                                .options = options,
                                .squeeze = squeezeOptionsOf(squeeze, options.friction, hand)};
    options.efforts = description.squeeze->efforts;
    description.options = options;
    (void)protocolsNamed(arguments.trials.protocols, "--trial");  // an error comes before the plan
    OutputFolder output(arguments.output);
    PlanJournal journal(output.folder(), description, hand, object, arguments.resume);
    if (!arguments.quiet)
    {
        printNotes(journal, arguments);
    }
    const StopRequest stop;  // the planner itself keeps the time limit
    runPlan(run,
            options,
            arguments.quiet,
            {.progress = [&](const Grasp& grasp) { journal.append(grasp); },
             .obstacles = bodies,
             .reach = reachOf(arguments, hand),
             .known = journal.known(),
             .stop = [&] { return stop.isInterrupted(); }});
    if (arguments.rank == "score")
    {
        rankByScore(run, arguments.options.mass);
    }
    TriedCount tried;
    if (!arguments.trials.protocols.empty())
    {
        tried = tryGrasps(arguments.trials, bodies, arguments.quiet, stop, run, description);
        if (arguments.trials.refine > 0)
        {
            fmt::print("refined: {} of {} grasps hold in more trials than before\n",
                       tried.improved,
                       tried.done);
        }
    }
    std::vector<Obstacle> shown = obstacles;
    if (arguments.options.approach.tableTop)
    {
        shown.back() = shownTableUnder(object, arguments.options.approach.up);
    }
    DrawingOptions drawing = arguments.drawing;
    drawing.scene = arguments.scene;
    const ObstacleList list{.inReach = obstacles};
    drawing.uses = &run.uses;
    drawing.obstacles = &list;
    std::vector<std::string> written =
        writePlanOutputs(output, description, hand, object, run.grasps, drawing, bodiesOf(shown));
    if (run.grasps.size() == static_cast<std::size_t>(arguments.options.candidates))
    {
        journal.remove();
    }
    else
    {
        written.push_back(journal.file().string());
    }
    printSummary(arguments, run, description, obstacles, stop.isInterrupted(), written);
    if (tried.done < tried.count)
    {
        return stop.finish("grasp plan --trial", tried.done, tried.count, "grasps", kNothingFound);
    }
    return stop.finish("grasp plan",
                       run.grasps.size(),
                       static_cast<std::size_t>(arguments.options.candidates),
                       "candidates",
                       forceClosures(run.grasps) > 0 ? kDone : kNothingFound);
}

void addStoppingOptions(CLI::App& command, PlanArguments& arguments)
{
    command
        .add_option("--time-limit",
                    arguments.options.timeLimit,
                    "Begin no further candidate after S seconds; 0 sets no limit.")
        ->type_name("S")
        ->check(within(0.0, 1e9))
        ->capture_default_str()
        ->group("Search");
    command
        .add_flag("--resume",
                  arguments.resume,
                  "Go on with what a run that was stopped, was killed or met its time limit has "
                  "left in the "
                  "output folder. The result is that of a run that was never stopped.")
        ->group("Search");
}
}  // namespace

void addPlanCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand("plan", "Plans and ranks grasps of an object by a hand.");
    const auto arguments = std::make_shared<PlanArguments>();
    addPairOptions(*command, arguments->pair);
    addSceneOption(*command, arguments->scene);
    command
        ->add_option("--robot",
                     arguments->robot.arm,
                     "An arm that carries the hand: a file, or the name of one that ships. Force "
                     "closures to which it does not bring the hand are rejected.")
        ->type_name("ARM");
    command
        ->add_option("--robot-pose",
                     arguments->robotPose,
                     "The pose of the arm's root in the object. Default: the identity.")
        ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
        ->check(parsedBy(poseFromText));
    addMountOptions(*command, arguments->robot);
    addPlannerOptions(*command, arguments->options);
    addFingersOption(*command, arguments->options.closing);
    addStoppingOptions(*command, *arguments);
    addSqueezeOptions(*command, arguments->squeeze);
    command
        ->add_option("--rank",
                     arguments->rank,
                     "What ranks force closures: epsilon, or score, the chance that a simulated "
                     "trial holds by what the efforts hold and how far apart the contacts are.")
        ->type_name("WHAT")
        ->check(CLI::IsMember({"epsilon", "score"}).description(""))
        ->capture_default_str()
        ->group("Squeeze");
    CLI::Option* trial =
        command
            ->add_option(
                "--trial",
                arguments->trials.protocols,
                "Try the best grasps in simulations, and rank first what held in more of them: "
                "names or YAML files of protocols, with commas between (see grasp trial "
                "--help).")
            ->type_name("NAME")
            ->group("Trials");
    command->add_option("--tried", arguments->trials.tried, "How many of the best grasps to try.")
        ->type_name("K")
        ->check(within(1, 100000))
        ->needs(trial)
        ->capture_default_str()
        ->group("Trials");
    command->add_flag("--brief", arguments->trials.brief, "Brief trials, as of grasp trial.")
        ->needs(trial)
        ->group("Trials");
    command
        ->add_option("--refine",
                     arguments->trials.refine,
                     "After a trial that failed, move the hand by what slipped, close and try "
                     "again, so many times, and keep what holds in more trials.")
        ->type_name("N")
        ->check(within(0, 10))
        ->needs(trial)
        ->capture_default_str()
        ->group("Trials");
    command
        ->add_option(
            "-o,--output",
            arguments->output,
            "The folder for grasps.jsonl, grasps.isaac.yaml, report.html, pictures and models. "
            "They replace those of an earlier run at the end.")
        ->type_name("FOLDER")
        ->capture_default_str()
        ->group("Output");
    command
        ->add_flag("--boxes",
                   arguments->drawing.sweptBoxes,
                   "Also draw the boxes that links sweep while they close.")
        ->group("Output");
    command
        ->add_option("--pictures",
                     arguments->drawing.pictures,
                     "How many of the best grasps to draw as PNG.")
        ->type_name("K")
        ->check(within(0, 99))
        ->capture_default_str()
        ->group("Output");
    command
        ->add_option(
            "--models",
            arguments->drawing.models,
            "How many of the best grasps to write as glTF models (.glb) for a 3-D viewer. Default: "
            "as many as pictures.")
        ->type_name("K")
        ->check(within(0, 99))
        ->group("Output");
    command->add_flag("-q,--quiet", arguments->quiet, "Print no progress and no notes on stderr.")
        ->group("Output");
    command->footer(
        "After Ctrl-C, or at the time limit, the files hold what was found, the last line on "
        "stderr says "
        "how many candidates were tried, and --resume goes on with the others.\n"
        "\n"
        "Exit codes: 0 if a force closure was found, 1 if none was, 130 after Ctrl-C, 2 for wrong "
        "options, 3 for bad input.\n"
        "\n"
        "Examples:\n"
        "  grasp plan --hand anthropomorphic_hand --object mug -n 20 -o out\n"
        "  grasp plan --hand parallel_gripper --object mug --trial lift,six --mass 0.2\n"
        "  grasp plan --config plan.yaml --seed 2 --time-limit 600 -o out");
    command->callback([arguments, &exitCode] { exitCode = plan(*arguments); });
}
}  // namespace bullet_ccd::tools
