#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/report/grasp_picture.h"
#include "grasp/report/motion_page.h"
#include "grasp/task/plan_file.h"
#include "grasp/task/single_hand.h"
#include "grasp/task/task_page.h"
#include "grasp/trial/two_hands_execution.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/grasp_cli/options/robot_options.h"
#include "tools/grasp_cli/plan/output_folder.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
/// Of the board on which the object stands [m].
const Eigen::Vector3d kBoard(0.4, 0.12, 0.02);

struct BimanualArguments
{
    std::vector<std::string> objects;
    double scale = 1.0;
    RobotArguments robot;
    double apart = 0.9;
    std::vector<double> place{0.55, 0.0, 0.35};
    std::string output;
    bool quiet = false;
    bool executes = false;
    int samples = 0;
    std::int64_t oneHand = 0;
    std::optional<double> mass;
    double timeLimit = 0.0;
    grasp::TwoHandOptions options;
};

struct BimanualRow
{
    std::string object;
    grasp::TwoHandPlan plan;
    double seconds = 0.0;  ///< to plan, without the simulation
    double sampled = 0.0;  ///< the smallest distance at samples [m]
    int doubted = 0;       ///< legs with a sample below their clearance
    std::optional<grasp::LiftResult> result;
    std::optional<grasp::SingleHandSearch> alone;

    [[nodiscard]] bool isGood() const { return plan.solved && doubted == 0; }
};

/// What ships of large/, sorted.
std::vector<std::string> largeObjects()
{
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry :
         std::filesystem::directory_iterator(shareFolder() / "objects" / "large", error))
    {
        if (entry.path().extension() == ".obj")
        {
            names.push_back("large/" + entry.path().stem().string());
        }
    }
    std::ranges::sort(names);
    return names;
}

/// What the page says beside the plan itself.
std::vector<std::pair<std::string, std::string>> factsOf(const BimanualRow& row)
{
    std::vector<std::pair<std::string, std::string>> facts{
        {"planned in", fmt::format("{:.2f} s", row.seconds)}};
    if (row.alone)
    {
        facts.emplace_back("one hand alone",
                           fmt::format("{} candidates, of which {} are force closures, and {} hold "
                                       "the weight with full efforts",
                                       row.alone->candidates,
                                       row.alone->forceClosures,
                                       row.alone->holding));
    }
    if (row.result)
    {
        facts.emplace_back(
            "in the simulation",
            row.result->succeeded
                ? fmt::format("lifted by {:.1f} mm, {:.1f} mm off, turned by {:.1f} degrees",
                              1e3 * row.result->risen,
                              1e3 * row.result->missed,
                              57.29578 * row.result->turned)
                : row.result->reason);
    }
    return facts;
}

void writeOutputs(const std::string& folder, const grasp::TwoHandTask& task, const BimanualRow& row)
{
    OutputFolder output(folder);
    std::ofstream out(output.stage("plan.json"));
    grasp::writeLiftJson(out, task, row.plan);
    out.close();
    if (!out)
    {
        throw std::runtime_error("plan.json: cannot be written: is the disk full?");
    }
    grasp::TaskPageExtras extras{.viewer = viewerFile(kTaskViewer),
                                 .picture = row.plan.solved ? "plan.png" : "",
                                 .files = {"plan.json"},
                                 .facts = factsOf(row)};
    if (row.plan.solved)
    {
        grasp::writeLiftModel(task, row.plan, output.stage("plan.glb"));
        grasp::drawLift(task, row.plan, output.stage("plan.png"));
        extras.files.insert(extras.files.end(), {"plan.glb", "plan.png"});
    }
    grasp::writeTaskPage(task, row.plan, extras, output.stage("report.html"));
    output.commit();
}

BimanualRow planOne(const BimanualArguments& a,
                    const grasp::TwoArms& arms,
                    const std::string& name,
                    bool isOnly,
                    const StopRequest& stop)
{
    const LoadedObject loaded = loadNamedObject(name, a.scale);
    const grasp::GraspObject& object = loaded.object;
    const SsvTree board = buildSsvTree(makeBox(0.5 * kBoard));
    const Eigen::Vector3d place(a.place[0], a.place[1], a.place[2]);
    const RigidBody stand{.tree = &board,
                          .motion = restAt(Eigen::Isometry3d(Eigen::Translation3d(
                              place - Eigen::Vector3d(0.0, 0.0, 0.5 * kBoard.z()))))};
    const Eigen::AlignedBox3d box = bounds(object.tree.mesh());
    const Eigen::Vector3d foot(box.center().x(), box.center().y(), box.min().z());
    const grasp::TwoHandTask task{.arms = arms,
                                  .start = {grasp::startPositions(*arms.arms[0].robot, {}),
                                            grasp::startPositions(*arms.arms[1].robot, {})},
                                  .object = object,
                                  .X_WO = Eigen::Isometry3d(Eigen::Translation3d(place - foot)),
                                  .obstacles = std::span(&stand, 1),
                                  .obstacleNames = {"stand"}};
    BimanualRow row;
    row.object = loaded.object.name;
    grasp::TwoHandOptions options = a.options;
    options.common.stop = stop.condition();
    if (a.oneHand > 0)
    {
        grasp::PickPlaceOptions alone = options.common;
        alone.grasps.candidates = a.oneHand;
        row.alone = grasp::searchSingleHand(*arms.arms[0].hand, object, alone);
    }
    double simulated = 0.0;
    if (a.executes)
    {
        options.objection = [&](const grasp::TwoHandPlan& plan)
        {
            const Stopwatch watch;
            row.result = grasp::executeLift(task,
                                            plan,
                                            {.mass = a.mass,
                                             .friction = options.common.grasps.friction,
                                             .stop = stop.condition()});
            simulated += watch.seconds();
            return row.result->reason;
        };
    }
    const Stopwatch watch;
    row.plan = grasp::planTwoHands(task, options);
    row.seconds = watch.seconds() - simulated;
    row.sampled = std::numeric_limits<double>::infinity();
    for (std::size_t leg = 0; row.plan.solved && a.samples > 0 && leg < row.plan.legs.size(); ++leg)
    {
        const double least = grasp::sampledDistance(task, row.plan, leg, a.samples);
        row.sampled = std::min(row.sampled, least);
        row.doubted += least < row.plan.legs[leg].clearance ? 1 : 0;
    }
    if (!a.output.empty())
    {
        writeOutputs(isOnly ? a.output : a.output + "/" + folderNameOf(row.object), task, row);
    }
    return row;
}

TextTable rowsTable(const BimanualArguments& a, const std::vector<BimanualRow>& rows)
{
    TextTable table{.header = {"object",
                               "kg",
                               "planned in [s]",
                               "pairs",
                               "tried",
                               "epsilon: left, right, both",
                               "weight by [N]: left, right",
                               "of effort [%]",
                               "squeeze [N]",
                               "internal [N]"},
                    .rows = {}};
    if (a.oneHand > 0)
    {
        table.header.emplace_back("one hand: tried, force closures, hold it");
    }
    if (a.samples > 0)
    {
        table.header.insert(table.header.end(), {"least sample [mm]", "legs in doubt"});
    }
    if (a.executes)
    {
        table.header.insert(table.header.end(), {"risen [mm]", "missed by [mm]", "turned [deg]"});
    }
    table.header.emplace_back("outcome");
    for (const BimanualRow& row : rows)
    {
        const grasp::TwoHandPlan& plan = row.plan;
        std::vector<std::string> cells{row.object,
                                       fmt::format("{:.2f}", plan.mass.mass),
                                       fmt::format("{:.2f}", row.seconds),
                                       std::to_string(plan.pairs),
                                       std::to_string(plan.attempts.size())};
        if (plan.solved)
        {
            cells.insert(
                cells.end(),
                {fmt::format("{:.3f}, {:.3f}, {:.3f}",
                             plan.aloneEpsilon[0],
                             plan.aloneEpsilon[1],
                             plan.grasp.quality.epsilon),
                 fmt::format("{:.1f}, {:.1f}", plan.forces.normal[0], plan.forces.normal[1]),
                 fmt::format("{:.1f}", 1e2 * plan.forces.effort),
                 fmt::format("{:.0f}", plan.forces.squeeze),
                 fmt::format("{:.0f}", plan.forces.internal)});
        }
        cells.resize(10);
        if (row.alone)
        {
            cells.push_back(fmt::format(
                "{}, {}, {}", row.alone->candidates, row.alone->forceClosures, row.alone->holding));
        }
        if (a.samples > 0)
        {
            cells.push_back(plan.solved ? fmt::format("{:.4f}", 1e3 * row.sampled) : "");
            cells.push_back(plan.solved ? std::to_string(row.doubted) : "");
        }
        if (a.executes)
        {
            cells.push_back(row.result ? fmt::format("{:.1f}", 1e3 * row.result->risen) : "");
            cells.push_back(row.result ? fmt::format("{:.1f}", 1e3 * row.result->missed) : "");
            cells.push_back(row.result ? fmt::format("{:.1f}", 57.29578 * row.result->turned) : "");
        }
        cells.push_back(!plan.solved ? plan.failure : a.executes ? "lifted" : "planned");
        table.rows.push_back(std::move(cells));
    }
    return table;
}

/// A page with the rows of all objects, which leads to theirs, and the lifts side by side.
void writeOverview(const BimanualArguments& a,
                   const std::vector<BimanualRow>& rows,
                   const TextTable& table)
{
    OutputFolder output(a.output);
    std::vector<std::filesystem::path> pictures;
    grasp::MotionPage page{.title = "Two hands"};
    for (const BimanualRow& row : rows)
    {
        page.files.push_back(folderNameOf(row.object) + "/report.html");
        if (row.plan.solved)
        {
            pictures.push_back(std::filesystem::path(a.output) / folderNameOf(row.object) /
                               "plan.png");
        }
    }
    page.subtitle = fmt::format(
        "{} of {} objects are {}", pictures.size(), rows.size(), a.executes ? "lifted" : "planned");
    page.isGood = pictures.size() == rows.size();
    page.tables.push_back({.title = "Objects", .header = table.header, .rows = table.rows});
    if (!pictures.empty())
    {
        grasp::joinPictures(pictures, 3, 5, output.stage("lifted.png"));
    }
    grasp::writeMotionPage(
        page, {}, pictures.empty() ? "" : "lifted.png", output.stage("report.html"));
    output.commit();
}

std::string attemptsText(const BimanualRow& row)
{
    TextTable table{.header = {"left", "right", "failed leg", "reason"}, .rows = {}};
    for (const grasp::PairAttempt& attempt : row.plan.attempts)
    {
        if (!attempt.leg.empty())
        {
            table.rows.push_back({std::to_string(attempt.candidates[0]),
                                  std::to_string(attempt.candidates[1]),
                                  attempt.leg,
                                  attempt.reason});
        }
    }
    return table.rows.empty() ? std::string() : row.object + ":\n" + alignedText(table) + "\n";
}

/// Both arms of one file, or the one that both are.
std::vector<LoadedRobot> loadArms(const RobotArguments& arguments)
{
    std::vector<LoadedRobot> robots;
    if (arguments.hand.empty())
    {
        for (LoadedRobot& robot : loadTwoArms(arguments))
        {
            robots.push_back(std::move(robot));
        }
        return robots;
    }
    robots.push_back(loadRobot(arguments));
    return robots;
}

int runBimanual(const BimanualArguments& a)
{
    const bool isOne = a.robot.hand.empty();  // with both arms
    const std::vector<LoadedRobot> robots = loadArms(a.robot);
    const auto standing = [&](const LoadedRobot& robot, double y)
    {
        return grasp::PlacedArm{
            .hand = &robot.hand.hand,
            .robot = &robot.robot,
            .X_WR = Eigen::Isometry3d(Eigen::Translation3d(0.0, isOne ? 0.0 : y, 0.0))};
    };
    using Prefixes = std::array<std::string, 2>;
    const grasp::TwoArms arms = grasp::joinArms(
        {standing(robots.front(), 0.5 * a.apart), standing(robots.back(), -0.5 * a.apart)},
        isOne ? Prefixes{} : Prefixes{"left_", "right_"});
    const std::vector<std::string> objects = a.objects.empty() ? largeObjects() : a.objects;
    if (!a.output.empty())
    {
        std::vector<std::string> names;
        std::ranges::transform(objects,
                               std::back_inserter(names),
                               [](const std::string& object)
                               { return std::filesystem::path(object).stem().string(); });
        requireOwnFolders(names);
    }
    const StopRequest stop(a.timeLimit);
    std::vector<BimanualRow> rows;
    for (const std::string& object : objects)
    {
        if (!rows.empty() && stop.isDue())
        {
            break;
        }
        rows.push_back(planOne(a, arms, object, objects.size() == 1, stop));
        if (!a.quiet)
        {
            fmt::print("{}", attemptsText(rows.back()));
            static_cast<void>(std::fflush(stdout));
        }
    }
    const TextTable table = rowsTable(a, rows);
    fmt::print("{}", alignedText(table));
    if (!a.output.empty() && objects.size() > 1)
    {
        writeOverview(a, rows, table);
    }
    if (a.oneHand > 0)
    {
        const auto isOfTwo = [](const BimanualRow& row)
        { return row.isGood() && row.alone->forceClosures == 0; };
        fmt::print("{} of {} objects: {} by two hands, and no force closure of one\n",
                   std::ranges::count_if(rows, isOfTwo),
                   rows.size(),
                   a.executes ? "lifted" : "planned");
    }
    std::size_t good = 0;
    std::size_t ended = 0;
    for (const BimanualRow& row : rows)
    {
        good += row.isGood() ? 1 : 0;
        ended += row.plan.stopped ? 0 : 1;
    }
    return stop.finish("grasp task bimanual",
                       ended,
                       objects.size(),
                       "objects",
                       good == objects.size() ? kDone : kNothingFound);
}

constexpr const char* kBimanualFooter =
    "Two arms with the same hand stand side by side, or are one robot (--arm without --hand), and "
    "lift an object that stands on a board before them. Of the hand's candidates, those that touch "
    "the object and are no force closure "
    "are taken in pairs, one for each arm, where both together are one. Both hands come at once, "
    "close at once, squeeze and lift; every motion is certified with both arms moving.\n"
    "\n"
    "The columns: with --one-hand, how many candidates one hand alone has tried, how many of them "
    "are force closures at any depth, and how many of these hold the weight with their full "
    "efforts; epsilon of each hand alone and of both; the normal forces of each hand that "
    "carry the weight at least, and the largest share of its effort that a joint needs for them; "
    "the normal forces of the squeeze, and the force with which the hands press towards each other "
    "(internal).\n"
    "\n"
    "With --execute, arms and hands follow the plan in a Bullet world, driven by position "
    "controllers of limited effort. A pair is taken if the object is within 1 cm of where the lift "
    "brings it after a second there, has turned by no more than 5 degrees, and nothing was "
    "penetrated; else the next one is tried.\n"
    "\n"
    "Exit codes: 0 if there is a plan for each object, else 1, 2 for wrong options, 3 for bad "
    "input, 130 after Ctrl-C.\n"
    "\n"
    "Example:\n"
    "  grasp task bimanual large/ball --arm seven_joint_arm --hand three_finger_gripper \\\n"
    "      --execute -o out";
}  // namespace

void addBimanual(CLI::App& task, int& exitCode)
{
    auto* command =
        task.add_subcommand("bimanual", "Plans how two arms lift what one hand cannot hold.");
    const auto a = std::make_shared<BimanualArguments>();
    a->options.common.grasps.candidates = 240;
    command
        ->add_option("OBJECTS",
                     a->objects,
                     "Mesh files, or names of objects that ship. Default: all of large/.")
        ->type_name("OBJECT...");
    command->add_option("--object-scale", a->scale, "Factor of mesh coordinates to metres.")
        ->type_name("S")
        ->check(within(1e-6, 1e6))
        ->capture_default_str();
    addRobotOptions(*command, a->robot);
    command
        ->add_option("--apart",
                     a->apart,
                     "How far apart the arms stand [m], along y: the left one at positive y. Of "
                     "one robot with both "
                     "arms they stand where it says.")
        ->type_name("D")
        ->check(within(1e-2, 1e2))
        ->capture_default_str();
    command
        ->add_option("--place",
                     a->place,
                     "Where the object stands [m]: x, y and z; the arms stand at x = z = 0.")
        ->type_name("X,Y,Z")
        ->delimiter(',')
        ->expected(3)
        ->capture_default_str();
    command
        ->add_option("-n,--candidates",
                     a->options.common.grasps.candidates,
                     "How many candidates of a hand are planned.")
        ->type_name("N")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000}))
        ->capture_default_str();
    command->add_option("--tries", a->options.common.graspsTried, "How many pairs are tried.")
        ->type_name("N")
        ->check(within(1, 1'000'000))
        ->capture_default_str();
    addTimeLimitOption(*command, a->timeLimit, "End the search");
    command->add_option("--seed", a->options.common.seed, "The seed of candidates and paths.")
        ->type_name("N")
        ->check(wholeNumber())
        ->capture_default_str();
    command->add_option("--lift", a->options.common.lift, "How far the object is lifted [m].")
        ->type_name("D")
        ->check(within(1e-3, 1.0))
        ->capture_default_str();
    command
        ->add_option(
            "-o,--output",
            a->output,
            "A folder for report.html, a page in three dimensions, plan.json, plan.glb, an "
            "animation, and plan.png; for more than one object, one in it for each, and a "
            "page and a picture of all.")
        ->type_name("FOLDER");
    command
        ->add_option(
            "--samples",
            a->samples,
            "Measure the distances anew at N samples of each motion between two waypoints.")
        ->type_name("N")
        ->check(within(0, 1'000'000))
        ->capture_default_str();
    command
        ->add_option(
            "--one-hand",
            a->oneHand,
            "Also look for grasps of one hand alone: N candidates all around, and N across "
            "what is thin. 0: do not.")
        ->type_name("N")
        ->check(within(std::int64_t{0}, std::int64_t{1'000'000}))
        ->capture_default_str();
    command->add_flag("--execute", a->executes, "Lift the object in a simulation, too.");
    addMassOption(
        *command, a->mass, 1e-3, fmt::format("The mass of each object [kg]. {}", kMassDefault));
    command->add_flag("-q,--quiet", a->quiet, "Do not list the pairs that failed.");
    command->footer(kBimanualFooter);
    command->callback(
        [a, &exitCode]
        {
            a->options.common.grasps.seed = a->options.common.seed;
            a->options.common.grasps.mass = a->mass;
            exitCode = runBimanual(*a);
        });
}
}  // namespace bullet_ccd::tools
