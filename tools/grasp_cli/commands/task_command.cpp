#include "tools/grasp_cli/commands/commands.h"
#ifdef BULLET_CCD_HAS_TASKS
#include "bullet_ccd/io/nearest_name.h"
#include "grasp/task/plan_file.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/grasp_cli/inputs/task_scene.h"
#include "tools/grasp_cli/plan/output_folder.h"
#include "tools/support/pose_text.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <memory>
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
    std::string arm;
    std::string hand;
    std::string srdf;
    std::string flange;
    std::string mount;
    std::string object;
    std::string output;
    bool quiet = false;
    double timeLimit = 0.0;
    grasp::PickPlaceOptions options;
};

Eigen::Isometry3d mountOf(const std::string& text)
{
    const std::vector<double> values = numbersFrom(text, 7);
    return poseFrom(std::span<const double, 7>(values.data(), 7));
}

/// Positions of the arm's joints where the scene says, else 0 within the limits.
std::vector<double> startOf(const TaskScene& scene, const grasp::ArmRobot& robot)
{
    std::vector<double> start;
    std::vector<std::string> names;
    for (const std::int32_t link : robot.joints)
    {
        const Joint& joint = robot.tree.links[static_cast<std::size_t>(link)].joint;
        start.push_back(std::clamp(0.0, joint.lower, joint.upper));
        names.push_back(joint.name);
    }
    for (const auto& [name, position] : scene.start)
    {
        const auto found = std::ranges::find(names, name);
        if (found == names.end())
        {
            throw std::runtime_error(
                fmt::format("{}: start: the arm has no joint {} above its hand: did you mean {}?",
                            scene.file.string(),
                            name,
                            nearestName(name, names)));
        }
        const auto k = static_cast<std::size_t>(found - names.begin());
        const Joint& joint = robot.tree.links[static_cast<std::size_t>(robot.joints[k])].joint;
        if (!(position >= joint.lower && position <= joint.upper))
        {
            throw std::runtime_error(fmt::format("{}: start: {} of joint {} is not within {} to {}",
                                                 scene.file.string(),
                                                 position,
                                                 name,
                                                 joint.lower,
                                                 joint.upper));
        }
        start[k] = position;
    }
    return start;
}

const TaskBody& chosenObject(const PickPlaceArguments& a, const TaskScene& scene)
{
    std::vector<std::string> names;
    for (const TaskBody& object : scene.objects)
    {
        if (object.name == a.object)
        {
            return object;
        }
        names.push_back(object.name);
    }
    throw std::runtime_error(fmt::format("{}: objects: there is no {}: the scene has {}",
                                         scene.file.string(),
                                         a.object,
                                         joined(names, ", ")));
}

std::string attemptsText(const grasp::PickPlacePlan& plan)
{
    TextTable table{.header = {"candidate", "failed leg", "reason"}, .rows = {}};
    for (const grasp::TaskAttempt& attempt : plan.attempts)
    {
        if (!attempt.leg.empty())
        {
            table.rows.push_back({std::to_string(attempt.candidate), attempt.leg, attempt.reason});
        }
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

void writeOutputs(const std::string& folder,
                  const grasp::PickPlaceTask& task,
                  const grasp::PickPlacePlan& plan)
{
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
    if (plan.solved)
    {
        write("trajectory.csv", grasp::writePlanCsv);
        write("trajectory.yaml", grasp::writePlanYaml);
        grasp::writePlanModel(task, plan, output.stage("plan.glb"));
    }
    output.commit();
    fmt::print("written:  {}/plan.json{}\n",
               folder,
               plan.solved ? ", trajectory.csv, trajectory.yaml, plan.glb" : "");
}

int runPickPlace(const PickPlaceArguments& a)
{
    const TaskScene scene = readTaskScene(resolveScene(a.scene));
    const LoadedHand hand = loadNamedHand(a.hand, a.srdf);
    const RobotModel arm = loadRobot(resolveArm(a.arm));
    const grasp::ArmRobot robot =
        grasp::mountHand(arm,
                         hand.hand,
                         a.flange,
                         a.mount.empty() ? Eigen::Isometry3d::Identity() : mountOf(a.mount));
    const TaskBody& chosen = chosenObject(a, scene);
    const grasp::GraspObject object = grasp::makeGraspObject(chosen.name, chosen.tree->mesh());
    std::vector<RigidBody> bodies;
    std::vector<std::string> names;
    for (const auto* list : {&scene.obstacles, &scene.objects})
    {
        for (const TaskBody& body : *list)
        {
            if (&body != &chosen)
            {
                bodies.push_back({.tree = body.tree.get(), .motion = restAt(body.X_WO)});
                names.push_back(body.name);
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
    const StopRequest stop(a.timeLimit);
    grasp::PickPlaceOptions options = a.options;
    options.stop = stop.condition();
    const Stopwatch watch;
    const grasp::PickPlacePlan plan = grasp::planPickPlace(task, options);
    const double seconds = watch.seconds();
    if (!a.quiet)
    {
        fmt::print("{}", attemptsText(plan));
    }
    if (plan.solved)
    {
        fmt::print("{}\n{} is moved by candidate {} (epsilon {:.3f}), planned in {:.2f} s\n",
                   legsText(plan),
                   a.object,
                   plan.grasp.candidate,
                   plan.grasp.quality.epsilon,
                   seconds);
    }
    if (!a.output.empty())
    {
        writeOutputs(a.output, task, plan);
    }
    if (plan.stopped)
    {
        return stop.finish(
            "grasp task pick-place",
            plan.attempts.size(),
            std::max(plan.attempts.size() + 1, static_cast<std::size_t>(a.options.graspsTried)),
            "grasps that may be tried",
            kNothingFound);
    }
    if (!plan.solved)
    {
        fmt::print(stderr, "grasp task pick-place: {}\n", plan.failure);
    }
    return plan.solved ? kDone : kNothingFound;
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
    "Exit codes: 0 if there is a plan, 1 if there is none (stderr says why), 2 for wrong options, "
    "3 "
    "for bad input.\n"
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
    command
        ->add_option(
            "--arm", a->arm, "A URDF, xacro or MJCF file, or the name of an arm that ships.")
        ->type_name("ARM")
        ->required();
    command
        ->add_option(
            "--hand", a->hand, "The hand at its end: a file, or the name of one that ships.")
        ->type_name("HAND")
        ->required();
    command->add_option("--srdf", a->srdf, "The SRDF of the hand. Default: the one beside it.")
        ->type_name("SRDF");
    command
        ->add_option(
            "--flange", a->flange, "The link that carries the hand. Default: the arm's end.")
        ->type_name("LINK");
    command
        ->add_option(
            "--mount", a->mount, "The pose of the hand's root link in it. Default: the identity.")
        ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
        ->check(parsedBy(mountOf));
    command->add_option("--object", a->object, "Which of the scene's objects is taken.")
        ->type_name("NAME")
        ->required();
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
            "A folder for plan.json, trajectory.csv, trajectory.yaml and plan.glb, an animation.")
        ->type_name("FOLDER");
    command->add_flag("-q,--quiet", a->quiet, "Do not list the grasps that failed.");
    command->footer(kPickPlaceFooter);
    command->callback(
        [a, &exitCode]
        {
            a->options.grasps.seed = a->options.seed;
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
