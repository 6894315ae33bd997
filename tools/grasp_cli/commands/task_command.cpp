#include "tools/grasp_cli/commands/commands.h"
#ifdef BULLET_CCD_HAS_TASKS
#include "grasp/report/grasp_picture.h"
#include "grasp/report/motion_page.h"
#include "grasp/task/plan_file.h"
#include "grasp/task/task_page.h"
#include "grasp/trial/plan_execution.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/grasp_cli/inputs/task_scene.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/grasp_cli/options/robot_options.h"
#include "tools/grasp_cli/plan/output_folder.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#endif
#include <stdexcept>

namespace bullet_ccd::tools
{
#ifdef BULLET_CCD_HAS_TASKS
namespace
{
struct PickPlaceArguments
{
    std::string scene;
    RobotArguments robot;
    std::vector<std::string> objects;
    std::string output;
    bool quiet = false;
    bool executes = false;
    bool rehearses = true;
    int samples = 0;
    std::optional<double> mass;
    double timeLimit = 0.0;
    std::string placePose = "stable";
    grasp::PickPlaceOptions options;
};

/// Positions of the arm's joints where the scene says, else 0 within the limits. A scene that names
/// none of them was made for another arm.
std::vector<double> startOf(const TaskScene& scene, const grasp::ArmRobot& robot)
{
    const auto isOfArm = [&](const auto& named)
    {
        return std::ranges::any_of(robot.joints,
                                   [&](std::int32_t link)
                                   {
                                       const auto i = static_cast<std::size_t>(link);
                                       return robot.tree.links[i].joint.name == named.first;
                                   });
    };
    if (!scene.start.empty() && std::ranges::none_of(scene.start, isOfArm))
    {
        fmt::print(stderr,
                   "note: {}: start is of another arm: {} has no joint {}: its joints start at 0, "
                   "or at the limit next to it\n",
                   scene.file.string(),
                   robot.name,
                   scene.start.front().first);
        return grasp::startPositions(robot, {});
    }
    try
    {
        return grasp::startPositions(robot, scene.start);
    }
    catch (const std::invalid_argument& error)
    {
        throw std::runtime_error(scene.file.string() + ": " + error.what());
    }
}

/// Those that are named, or all.
std::vector<const TaskBody*> chosenObjects(const PickPlaceArguments& a, const TaskScene& scene)
{
    std::vector<const TaskBody*> chosen;
    std::vector<std::string> names;
    for (const TaskBody& object : scene.objects)
    {
        names.push_back(object.name);
        if (a.objects.empty())
        {
            chosen.push_back(&object);
        }
    }
    for (const std::string& name : a.objects)
    {
        const auto found = std::ranges::find(scene.objects, name, &TaskBody::name);
        if (found == scene.objects.end())
        {
            throw std::runtime_error(fmt::format("{}: objects: there is no {}: the scene has {}",
                                                 scene.file.string(),
                                                 name,
                                                 joined(names, ", ")));
        }
        chosen.push_back(&*found);
    }
    return chosen;
}

/// The grasps that failed for the same reason share a row, which names the first of them.
std::string attemptsText(const grasp::PickPlacePlan& plan)
{
    struct Failed
    {
        const grasp::TaskAttempt* first;
        std::vector<std::string> candidates;
    };
    std::vector<Failed> failures;
    for (const grasp::TaskAttempt& attempt : plan.attempts)
    {
        if (attempt.leg.empty())
        {
            continue;
        }
        auto same = std::ranges::find_if(
            failures,
            [&](const Failed& each)
            { return each.first->leg == attempt.leg && each.first->reason == attempt.reason; });
        if (same == failures.end())
        {
            same = failures.insert(same, {.first = &attempt, .candidates = {}});
        }
        same->candidates.push_back(std::to_string(attempt.candidate));
    }
    TextTable table{.header = {"failed leg", "reason", "grasps", "candidates"}, .rows = {}};
    constexpr std::size_t kNamed = 4;
    for (const Failed& failed : failures)
    {
        const std::size_t count = failed.candidates.size();
        const std::vector<std::string> named(
            failed.candidates.begin(),
            failed.candidates.begin() + std::ptrdiff_t(std::min(count, kNamed)));
        table.rows.push_back({failed.first->leg,
                              failed.first->reason,
                              std::to_string(count),
                              joined(named, " ") + (count > kNamed ? " ..." : "")});
    }
    return table.rows.empty() ? std::string() : alignedText(table) + "\n";
}

std::string legsText(const grasp::PickPlacePlan& plan)
{
    TextTable table{
        .header = {"leg", "from [s]", "to [s]", "waypoints", "certified clearance [mm]"},
        .rows = {}};
    for (const grasp::TaskLeg& leg : plan.legs)
    {
        table.rows.push_back({leg.name,
                              fmt::format("{:.2f}", leg.waypoints.front().time),
                              fmt::format("{:.2f}", leg.waypoints.back().time),
                              std::to_string(leg.waypoints.size()),
                              leg.clearance >= grasp::kEnoughClearance
                                  ? fmt::format("at least {:g}", 1e3 * grasp::kEnoughClearance)
                                  : fmt::format("{:.3f}", 1e3 * leg.clearance)});
    }
    return alignedText(table);
}

/// What became of one object.
struct TaskRow
{
    std::string object;
    grasp::PickPlacePlan plan;
    double seconds = 0.0;                          ///< to plan
    double sampled = 0.0;                          ///< the smallest distance at samples [m]
    int doubted = 0;                               ///< legs with a sample below their clearance
    std::optional<grasp::ExecutionResult> result;  ///< of the simulation

    [[nodiscard]] bool isGood() const
    {
        return plan.solved && doubted == 0 && (!result || result->succeeded);
    }
};

/// What the page says beside the plan itself.
std::vector<std::pair<std::string, std::string>> factsOf(const TaskRow& row)
{
    std::vector<std::pair<std::string, std::string>> facts{
        {"planned in", fmt::format("{:.2f} s", row.seconds)}};
    if (row.result)
    {
        facts.emplace_back("in the simulation",
                           row.result->succeeded
                               ? fmt::format("done: {:.2f} mm off, others moved by {:.2f} mm",
                                             1e3 * row.result->missed,
                                             1e3 * row.result->othersMoved)
                               : row.result->reason);
    }
    return facts;
}

void writeOutputs(const std::string& folder, const grasp::PickPlaceTask& task, const TaskRow& row)
{
    const grasp::PickPlacePlan& plan = row.plan;
    OutputFolder output(folder);
    const auto write = [&](const std::string& name, const auto& writer)
    {
        std::ofstream out(output.stage(name));
        writer(out, task, plan);
        out.close();
        if (!out)
        {
            throw std::runtime_error(name + ": cannot be written: is the disk full?");
        }
    };
    write("plan.json", grasp::writePlanJson);
    grasp::TaskPageExtras extras{.viewer = viewerFile(kTaskViewer),
                                 .picture = plan.solved ? "plan.png" : "",
                                 .files = {"plan.json"},
                                 .facts = factsOf(row)};
    if (plan.solved)
    {
        write("trajectory.csv", grasp::writePlanCsv);
        write("trajectory.yaml", grasp::writePlanYaml);
        grasp::writePlanModel(task, plan, output.stage("plan.glb"));
        grasp::drawPlan(task, plan, output.stage("plan.png"));
        extras.files.insert(extras.files.end(),
                            {"trajectory.csv", "trajectory.yaml", "plan.glb", "plan.png"});
        for (std::size_t i = 0; i < plan.legs.size(); ++i)
        {
            extras.files.push_back(fmt::format("leg_{}_{}.csv", i + 1, plan.legs[i].name));
            write(extras.files.back(),
                  [&](std::ostream& out, const auto&, const auto&)
                  { grasp::writeLegCsv(out, task, plan.legs[i]); });
        }
        extras.files.insert(extras.files.end(), {"robot.urdf", "robot.srdf"});
    }
    grasp::writeTaskPage(task, plan, extras, output.stage("report.html"));
    output.commit();
    if (plan.solved)
    {
        grasp::writeRobot(task, folder);
    }
    fmt::print("written:  {}/report.html, {}\n", folder, joined(extras.files, ", "));
}

TaskRow planOne(const PickPlaceArguments& a,
                const TaskScene& scene,
                const LoadedHand& hand,
                const grasp::ArmRobot& robot,
                const TaskBody& chosen,
                bool isOnly,
                const StopRequest& stop)
{
    const grasp::GraspObject object = grasp::makeGraspObject(chosen.name, chosen.tree->mesh());
    std::vector<RigidBody> bodies;
    std::vector<std::string> names;
    std::vector<double> masses;
    for (const auto* list : {&scene.obstacles, &scene.objects})
    {
        for (const TaskBody& body : *list)
        {
            if (&body != &chosen)
            {
                bodies.push_back({.tree = body.tree.get(), .motion = restAt(body.X_WO)});
                names.push_back(body.name);
                masses.push_back(
                    a.executes && list == &scene.objects
                        ? grasp::massOf(grasp::makeGraspObject(body.name, body.tree->mesh()),
                                        a.mass)
                              .mass
                        : 0.0);
            }
        }
    }
    const grasp::PickPlaceTask task{
        .hand = hand.hand,
        .robot = robot,
        .X_WR = scene.X_WR,
        .start = startOf(scene, robot),
        .object = object,
        .X_WO = chosen.X_WO,
        .obstacles = bodies,
        .obstacleNames = names,
        .target = {.center = scene.targetCenter, .size = scene.targetSize}};
    grasp::PickPlaceOptions options = a.options;
    options.stop = stop.condition();
    const grasp::ExecutionOptions execution{.mass = a.mass,
                                            .friction = options.grasps.friction,
                                            .firmness = options.firmness,
                                            .obstacleMasses = masses,
                                            .stop = stop.condition()};
    if (a.rehearses)
    {
        options.objection = grasp::rehearsal(task, execution);
        options.holds = 1.0;  // the simulation asks for more
    }
    TaskRow row;
    row.object = chosen.name;
    const Stopwatch watch;
    row.plan = grasp::planPickPlace(task, options);
    row.seconds = watch.seconds();
    const double raised = row.plan.X_WOStart.translation().z() - chosen.X_WO.translation().z();
    if (raised > 2.0 * options.gap)
    {
        fmt::print(stderr,
                   "note: {} intersects what is below it by about {:.1f} mm where it starts: the "
                   "plan takes it from as much above\n",
                   chosen.name,
                   1e3 * (raised - options.gap));
    }
    constexpr double kFloats = 2e-3;
    if (row.plan.startHeight > kFloats)
    {
        fmt::print(stderr,
                   "note: {} {}: the plan takes it from there, but it would fall: correct its "
                   "position\n",
                   chosen.name,
                   std::isinf(row.plan.startHeight)
                       ? "has nothing below it"
                       : fmt::format("floats {:.1f} mm above what is below it",
                                     1e3 * row.plan.startHeight));
    }
    row.sampled = std::numeric_limits<double>::infinity();
    for (std::size_t leg = 0; row.plan.solved && a.samples > 0 && leg < row.plan.legs.size(); ++leg)
    {
        const double least = grasp::sampledDistance(task, row.plan, leg, a.samples);
        row.sampled = std::min(row.sampled, least);
        row.doubted += least < row.plan.legs[leg].clearance ? 1 : 0;
    }
    if (row.plan.solved && a.executes)
    {
        row.result = grasp::executePlan(task, row.plan, execution);
    }
    if (!a.output.empty())
    {
        writeOutputs(isOnly ? a.output : a.output + "/" + folderNameOf(chosen.name), task, row);
    }
    return row;
}

void printOne(const PickPlaceArguments& a, const TaskRow& row)
{
    if (!a.quiet)
    {
        fmt::print("{}", attemptsText(row.plan));
    }
    if (row.plan.solved)
    {
        fmt::print(
            "{}\n{} is moved by candidate {} (epsilon {:.3f}, holds {:.2f} kg of {}), planned in "
            "{:.2f} s\n",
            legsText(row.plan),
            row.object,
            row.plan.grasp.candidate,
            row.plan.grasp.quality.epsilon,
            row.plan.grasp.quality.largestMass.value_or(0.0),
            massText(row.plan.mass),
            row.seconds);
    }
}

TextTable rowsTable(const PickPlaceArguments& a, const std::vector<TaskRow>& rows)
{
    TextTable table{.header = {"object", "planned in [s]", "grasps tried", "takes [s]"},
                    .rows = {}};
    if (a.samples > 0)
    {
        table.header.insert(table.header.end(), {"least sample [mm]", "legs in doubt"});
    }
    if (a.executes)
    {
        table.header.insert(table.header.end(),
                            {"missed by [mm]", "others moved [mm]", "inexact [%]"});
    }
    table.header.emplace_back("outcome");
    for (const TaskRow& row : rows)
    {
        const grasp::PickPlacePlan& plan = row.plan;
        std::vector<std::string> cells{
            row.object,
            fmt::format("{:.2f}", row.seconds),
            std::to_string(plan.attempts.size()),
            plan.solved ? fmt::format("{:.1f}", plan.legs.back().waypoints.back().time) : ""};
        if (a.samples > 0)
        {
            cells.push_back(plan.solved ? fmt::format("{:.4f}", 1e3 * row.sampled) : "");
            cells.push_back(plan.solved ? std::to_string(row.doubted) : "");
        }
        if (a.executes)
        {
            const bool isWhole = row.result && !row.result->stopped;
            cells.push_back(isWhole ? fmt::format("{:.2f}", 1e3 * row.result->missed) : "");
            cells.push_back(isWhole ? fmt::format("{:.2f}", 1e3 * row.result->othersMoved) : "");
            cells.push_back(isWhole ? fmt::format("{:.1f}", 1e2 * row.result->inexact) : "");
        }
        cells.push_back(!plan.solved                           ? plan.failure
                        : row.result && !row.result->succeeded ? row.result->reason
                        : row.result                           ? "done"
                                                               : "planned");
        table.rows.push_back(std::move(cells));
    }
    return table;
}

/// A page with the rows of all objects, which leads to theirs, and a picture of the scene.
void writeOverview(const PickPlaceArguments& a,
                   const TaskScene& scene,
                   const std::vector<TaskRow>& rows,
                   const TextTable& table)
{
    OutputFolder output(a.output);
    grasp::MotionPage page{.title = scene.file.stem().string()};
    for (const TaskRow& row : rows)
    {
        page.files.push_back(folderNameOf(row.object) + "/report.html");
    }
    const auto good = std::ranges::count_if(rows, [](const TaskRow& row) { return row.isGood(); });
    page.subtitle =
        fmt::format("{} of {} objects are {}", good, rows.size(), a.executes ? "moved" : "planned");
    page.isGood = good == std::ptrdiff_t(rows.size());
    page.tables.push_back({.title = "Objects", .header = table.header, .rows = table.rows});
    drawScene(scene, output.stage("scene.png"));
    grasp::writeMotionPage(page, {}, "scene.png", output.stage("report.html"));
    output.commit();
}

int runPickPlace(const PickPlaceArguments& a)
{
    const TaskScene scene = readTaskScene(resolveScene(a.scene));
    const LoadedRobot robot = loadRobot(a.robot);
    const std::vector<const TaskBody*> chosen = chosenObjects(a, scene);
    if (!a.output.empty())
    {
        std::vector<std::string> names;
        std::ranges::transform(
            chosen, std::back_inserter(names), [](const TaskBody* object) { return object->name; });
        requireOwnFolders(names);
    }
    const StopRequest stop(a.timeLimit);
    std::vector<TaskRow> rows;
    std::size_t refused = 0;
    for (const TaskBody* object : chosen)
    {
        if (!rows.empty() && stop.isDue())
        {
            break;
        }
        try
        {
            rows.push_back(
                planOne(a, scene, robot.hand, robot.robot, *object, chosen.size() == 1, stop));
        }
        catch (const std::invalid_argument& error)
        {
            if (chosen.size() == 1)
            {
                throw;
            }
            // The others may well be moved.
            rows.emplace_back().object = object->name;
            rows.back().plan.failure = error.what();
            ++refused;
        }
    }
    if (refused == chosen.size())
    {
        throw std::runtime_error(rows.front().plan.failure);
    }
    const bool isTable = chosen.size() > 1 || a.samples > 0 || a.executes;
    if (chosen.size() == 1)
    {
        printOne(a, rows.front());
    }
    if (isTable)
    {
        const TextTable table = rowsTable(a, rows);
        fmt::print("{}", alignedText(table));
        if (!a.output.empty() && chosen.size() > 1)
        {
            writeOverview(a, scene, rows, table);
        }
    }
    std::size_t good = 0;
    std::size_t ended = 0;
    for (const TaskRow& row : rows)
    {
        good += row.isGood() ? 1 : 0;
        ended += row.plan.stopped || (row.result && row.result->stopped) ? 0 : 1;
        if (!row.plan.solved && !row.plan.stopped && !isTable)
        {
            fmt::print(stderr, "grasp task pick-place: {}\n", row.plan.failure);
        }
    }
    return stop.finish("grasp task pick-place",
                       ended,
                       chosen.size(),
                       "objects",
                       good == chosen.size() ? kDone : kNothingFound);
}

constexpr const char* kPickPlaceFooter =
    "The hand takes the object and puts it down in the target region of the scene. Every leg of "
    "the "
    "way is certified as a whole, as it is timed: nothing touches at any time, between samples "
    "neither. Where a leg of a grasp fails, the table says why, and the next grasp is tried.\n"
    "\n"
    "A scene is a YAML map with robot (position, rpy or quaternion, start: {JOINT: POSITION}), "
    "obstacles and objects (lists of items with mesh or box, name, position, rpy or quaternion), "
    "and "
    "target (position, size). grasp/task/README.md describes it, and plan.json.\n"
    "\n"
    "With --execute, arm and fingers follow the plan in a Bullet world, driven by position "
    "controllers of limited effort, and the scene's other objects are free. It is done if the "
    "object is within 1 cm of its place, no other has moved by more than 5 mm, and nothing was "
    "penetrated.\n"
    "\n"
    "Exit codes: 0 if there is a plan for each object (with --execute: and it is done), else 1, 2 "
    "for wrong options, 3 for bad input, 130 after Ctrl-C.\n"
    "\n"
    "Example:\n"
    "  grasp task pick-place table --arm seven_joint_arm --hand parallel_gripper \\\n"
    "      --object mug -o out";

void addPickPlace(CLI::App& task, int& exitCode)
{
    auto* command = task.add_subcommand(
        "pick-place", "Plans how an arm takes an object and puts it down elsewhere.");
    const auto a = std::make_shared<PickPlaceArguments>();
    command->add_option("SCENE", a->scene, "A scene in YAML, or the name of one that ships.")
        ->type_name("SCENE")
        ->required();
    addRobotOptions(*command, a->robot);
    command
        ->add_option("--object",
                     a->objects,
                     "Which of the scene's objects is taken. Default: each of them, in a table.")
        ->type_name("NAME");
    command
        ->add_option(
            "-n,--candidates", a->options.grasps.candidates, "How many grasps are planned.")
        ->type_name("N")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000}))
        ->capture_default_str();
    command->add_option("--tries", a->options.graspsTried, "How many of the best are tried.")
        ->type_name("N")
        ->check(within(1, 1'000'000))
        ->capture_default_str();
    addTimeLimitOption(*command, a->timeLimit, "End the search");
    command->add_option("--seed", a->options.seed, "The seed of grasps and paths.")
        ->type_name("N")
        ->check(wholeNumber())
        ->capture_default_str();
    command
        ->add_option(
            "--approach", a->options.approach, "How far the hand comes straight at the object [m].")
        ->type_name("D")
        ->check(within(1e-3, 1.0))
        ->capture_default_str();
    command->add_option("--lift", a->options.lift, "How far the object is lifted straight up [m].")
        ->type_name("D")
        ->check(within(1e-3, 1.0))
        ->capture_default_str();
    command
        ->add_option("--acceleration",
                     a->options.acceleration,
                     "The largest acceleration of a joint [rad/s^2 or m/s^2].")
        ->type_name("A")
        ->check(within(1e-3, 1e6))
        ->capture_default_str();
    command
        ->add_option(
            "-o,--output",
            a->output,
            "A folder for report.html (a page in three dimensions), plan.json, trajectory.csv, "
            "trajectory.yaml, each leg in CSV, the robot (robot.urdf, robot.srdf), plan.glb (an "
            "animation) and plan.png; for more than one object, one in it for each, and a page of "
            "all "
            "with scene.png.")
        ->type_name("FOLDER");
    command
        ->add_option(
            "--samples",
            a->samples,
            "Measure the distances anew at N samples of each motion between two waypoints.")
        ->type_name("N")
        ->check(within(0, 1'000'000))
        ->capture_default_str();
    command->add_flag(
        "--execute", a->executes, "Carry the plan out in a simulation, and judge it.");
    command->add_flag_callback(
        "--no-rehearsal",
        [a] { a->rehearses = false; },
        "Do not lift the object in a simulation of the hand alone before a grasp is tried.");
    command
        ->add_option(
            "--place-pose",
            a->placePose,
            "How the object is put down: as it stood (keep), or also on another face of its "
            "convex hull if no grasp leads to a plan otherwise (stable).")
        ->type_name("keep|stable")
        ->check(CLI::IsMember({"keep", "stable"}).description(""))
        ->capture_default_str();
    addMassOption(
        *command, a->mass, 1e-3, fmt::format("The mass of each object [kg]. {}", kMassDefault));
    command->add_flag("-q,--quiet", a->quiet, "Do not list why grasps failed.");
    command->footer(kPickPlaceFooter);
    command->callback(
        [a, &exitCode]
        {
            a->options.grasps.seed = a->options.seed;
            a->options.grasps.mass = a->mass;
            a->options.placesOnOtherFaces = a->placePose == "stable";
            exitCode = runPickPlace(*a);
        });
}
}  // namespace
#endif

void addTaskCommand(CLI::App& app, int& exitCode)
{
    auto* task = app.add_subcommand("task", "Plans whole tasks of an arm with a hand.");
#ifdef BULLET_CCD_HAS_TASKS
    task->require_subcommand(1);
    addPickPlace(*task, exitCode);
    addBimanual(*task, exitCode);
    addClutter(*task, exitCode);
    addScene(*task, exitCode);
#else
    task->allow_extras();
    task->callback(
        [&exitCode]
        {
            throw std::runtime_error(
                "grasp task: this build has no tasks, which need OMPL: "
                "run tools/install_dependencies --planning and build again");
        });
#endif
}
}  // namespace bullet_ccd::tools
