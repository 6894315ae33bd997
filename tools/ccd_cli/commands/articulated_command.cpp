#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/joint_file.h"
#include "tools/ccd_cli/run/articulated_run.h"
#include "tools/ccd_cli/text/articulated_text.h"
#include "tools/ccd_cli/text/batch_summary.h"
#include "tools/support/command_line.h"
#include "tools/support/obstacles/obstacle_list.h"
#include "tools/support/obstacles/obstacle_scene.h"
#include "tools/support/option_values.h"
#include "tools/support/pose_text.h"
#include "tools/support/progress_line.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_file.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
struct ArticulatedArguments
{
    std::string urdf;
    std::string srdf;
    std::string from;
    std::string to;
    std::string path;
    std::string baseFrom;
    std::string baseTo;
    std::vector<std::string> obstacles;
    bool self = false;
    double jointReach = kDefaultJointReach;
    int contacts = 1;
    StopRule rule = StopRule::Chain;
    bool json = false;
    std::string output;
    int repeat = 1;
    bool summary = false;
    double timeLimit = 0.0;
    ToiOptions toi;
};

void requireUsage(bool condition, const char* option, const char* what)
{
    if (!condition)
    {
        throw CLI::ValidationError(option, what);
    }
}

void checkUsage(const ArticulatedArguments& a)
{
    const bool isPath = !a.path.empty();
    const bool isBatch = !a.output.empty();
    requireUsage(a.self || !a.obstacles.empty(),
                 "--obstacles",
                 "there is nothing to touch: give --obstacles, --self or both");
    requireUsage(isPath != (!a.from.empty() && !a.to.empty()) && (!isPath || a.from.empty()),
                 "--from",
                 "give --from and --to, or --path");
    requireUsage(isBatch || !isPath, "--path", "has many queries: give -o for their results");
    requireUsage(!isBatch || (a.contacts == 1 && !a.json),
                 "--output",
                 "a table has the first contact only: leave out --contacts and --json");
    requireUsage(isBatch || !a.summary, "--summary", "sums up a table: give -o");
    requireUsage(
        a.srdf.empty() || a.self, "--srdf", "says which links to test: give --self as well");
}

void printNotes(const std::vector<std::string>& notes)
{
    for (const std::string& note : notes)
    {
        fmt::print(stderr, "bullet-ccd: {}\n", note);
    }
}

Eigen::Isometry3d poseFromText(const std::string& text)
{
    const std::vector<double> numbers = numbersFrom(text, 7);
    return poseFrom(std::span<const double, 7>(numbers.data(), 7));
}

/// Poses of the root at both ends: of the rows, or of the options.
RigidMotion rootMotion(const ArticulatedArguments& a,
                       const Configuration& from,
                       const Configuration& to)
{
    const Eigen::Isometry3d start = from.base.value_or(
        a.baseFrom.empty() ? Eigen::Isometry3d::Identity() : poseFromText(a.baseFrom));
    return motionBetween(start,
                         to.base.value_or(a.baseTo.empty() ? start : poseFromText(a.baseTo)));
}

ArticulatedQuery queryOf(const ArticulatedArguments& a,
                         const Configuration& from,
                         const Configuration& to)
{
    ArticulatedQuery query{.id = from.id, .motion = {}};
    query.motion.root = rootMotion(a, from, to);
    query.motion.positions = from.positions;
    for (std::size_t k = 0; k < from.positions.size(); ++k)
    {
        query.motion.rates.push_back(to.positions[k] - from.positions[k]);
    }
    return query;
}

JointFile readJoints(const ArticulatedArguments& a,
                     const std::string& path,
                     const KinematicTree& tree)
{
    JointFile file = readJointFile(path, tree);
    printNotes(file.notes);
    if (file.rows[0].base && !(a.baseFrom.empty() && a.baseTo.empty()))
    {
        throw std::runtime_error(path +
                                 ": has columns of the base: leave out --base-from and --base-to");
    }
    return file;
}

std::vector<ArticulatedQuery> pathQueries(const ArticulatedArguments& a, const KinematicTree& tree)
{
    const JointFile file = readJoints(a, a.path, tree);
    if (file.rows.size() < 2)
    {
        throw std::runtime_error(a.path + ": one row: a path has two configurations or more");
    }
    std::vector<ArticulatedQuery> queries;
    for (std::size_t k = 0; k + 1 < file.rows.size(); ++k)
    {
        queries.push_back(queryOf(a, file.rows[k], file.rows[k + 1]));
    }
    return queries;
}

std::vector<ArticulatedQuery> pairQueries(const ArticulatedArguments& a, const KinematicTree& tree)
{
    const JointFile from = readJoints(a, a.from, tree);
    const JointFile to = readJoints(a, a.to, tree);
    const auto sorted = [](std::vector<std::string> names)
    {
        std::sort(names.begin(), names.end());
        return names;
    };
    if (sorted(from.names) != sorted(to.names) ||
        from.rows[0].base.has_value() != to.rows[0].base.has_value())
    {
        throw std::runtime_error(fmt::format(
            "{}: other columns than {}: name the same joints in both files", a.to, a.from));
    }
    if (from.rows.size() != to.rows.size() || (a.output.empty() && from.rows.size() > 1))
    {
        throw std::runtime_error(
            fmt::format("{}: {} rows, and {} in {}: give one of each, or as many of each and -o",
                        a.from,
                        from.rows.size(),
                        to.rows.size(),
                        a.to));
    }
    std::vector<ArticulatedQuery> queries;
    for (std::size_t k = 0; k < from.rows.size(); ++k)
    {
        queries.push_back(queryOf(a, from.rows[k], to.rows[k]));
    }
    return queries;
}

/// Everything that queries are asked of.
struct World
{
    RobotLinks links;
    std::vector<Obstacle> obstacles;
    std::size_t outOfReach = 0;  ///< obstacles that were not loaded
    std::size_t trianglesOutOfReach = 0;
    std::vector<RigidBody> bodies;
    double seconds = 0.0;
};

World loadRobot(const ArticulatedArguments& a)
{
    const Stopwatch watch;
    World world{.links = loadRobotLinks(a.urdf), .obstacles = {}, .bodies = {}};
    if (a.self)
    {
        addSelfPairs(world.links, a.srdf, a.jointReach);
    }
    printNotes(world.links.notes);
    world.seconds = watch.seconds();
    return world;
}

/// Of manifests, what the queries can reach.
void loadSurroundings(const ArticulatedArguments& a,
                      const std::vector<ArticulatedQuery>& queries,
                      World& world)
{
    const Stopwatch watch;
    if (a.contacts == 1)
    {
        std::vector<Eigen::AlignedBox3d> reach;
        for (const ArticulatedQuery& query : queries)
        {
            addSweptBoxes(
                world.links, query.motion, a.toi.minimumSeparation + a.toi.tolerance, reach);
        }
        ObstacleList list = loadObstaclesWithin(a.obstacles, reach);
        world.obstacles = std::move(list.inReach);
        world.outOfReach = list.outOfReach;
        world.trianglesOutOfReach = list.trianglesOutOfReach;
    }
    else
    {
        world.obstacles = loadObstacles(a.obstacles);  // where joints stop, others go elsewhere
    }
    world.bodies = bodiesOf(world.obstacles);
    for (const RigidBody& obstacle : world.bodies)
    {
        checkAccuracy(a.toi, obstacle.tree->mesh());
    }
    for (const SsvTree* link : world.links.linkTrees)
    {
        if (link != nullptr)
        {
            checkAccuracy(a.toi, link->mesh());
        }
    }
    world.seconds += watch.seconds();
}

void print(const ArticulatedArguments& a, const World& world, const ArticulatedReport& report)
{
    const ArticulatedNames names{.links = world.links, .obstacles = world.obstacles};
    fmt::print("{}", a.json ? jsonText(report, names) : readableText(report, names, a.toi));
}

/// What the query, through all its contacts, needs of the meshes: it is asked once more for that.
std::optional<ModelShare> shareOf(const ArticulatedArguments& a,
                                  const World& world,
                                  const JointMotion& motion)
{
    if (!a.toi.anyWithin)
    {
        return std::nullopt;
    }
    ModelUse use;
    ToiWorkspace work;
    noteModelUse(work, &use);
    const ArticulatedBody body = world.links.body(motion);
    if (a.contacts == 1)
    {
        static_cast<void>(articulatedToi(body, Environment(world.bodies), {.toi = a.toi}, work));
    }
    else
    {
        static_cast<void>(articulatedContacts(
            body, world.bodies, {.query = {.toi = a.toi}, .rule = a.rule}, work));
    }
    std::vector<const SsvTree*> trees = world.links.linkTrees;
    for (const RigidBody& obstacle : world.bodies)
    {
        trees.push_back(obstacle.tree);
    }
    ModelShare share(use, trees);
    share.ofBodies += world.outOfReach;
    share.ofTriangles += world.trianglesOutOfReach;
    for (std::size_t k = 0; k < motion.rates.size(); ++k)
    {
        share.joints += motion.rates[k] != 0.0 ? 1 : 0;
        share.ofJoints += world.links.robot.tree.links[k].joint.isMovable() ? 1 : 0;
    }
    return share;
}

int answerOne(ArticulatedArguments a, const World& world, const ArticulatedQuery& query)
{
    const StopRequest stop(a.timeLimit);
    a.toi.stop = stop.condition();
    const auto exitCodeOf = [&](ToiStatus status)
    {
        const std::size_t done = status == ToiStatus::Stopped ? 0 : 1;
        return stop.finish("bullet-ccd articulated", done, 1, "queries", kDone);
    };
    if (a.contacts == 1)
    {
        const std::vector<ArticulatedAnswer> answers =
            runArticulated(world.links,
                           world.bodies,
                           std::span(&query, 1),
                           a.toi,
                           1,
                           [](std::size_t) { return true; });
        const ArticulatedToiResult& result = answers[0].result;
        print(a,
              world,
              {.status = result.status,
               .time = result.time,
               .contacts = result.contacts,
               .shown = result.contacts.size(),
               .counters = result.counters,
               .microseconds = answers[0].microseconds,
               .needed = shareOf(a, world, query.motion)});
        return exitCodeOf(result.status);
    }
    const SequenceAnswer answer = runSequence(
        world.links, world.bodies, query.motion, {.query = {.toi = a.toi}, .rule = a.rule});
    print(a,
          world,
          {.status = answer.sequence.status,
           .time = answer.sequence.time,
           .contacts = answer.sequence.contacts,
           .shown = static_cast<std::size_t>(a.contacts),
           .stopTimes = answer.sequence.stopTimes,
           .counters = answer.sequence.counters,
           .microseconds = answer.microseconds,
           .needed = shareOf(a, world, query.motion)});
    return exitCodeOf(answer.sequence.status);
}

void printSummary(const std::vector<ArticulatedAnswer>& answers, const World& world, double wall)
{
    std::vector<TimedAnswer> timed;
    for (const ArticulatedAnswer& answer : answers)
    {
        TimedAnswer& row = timed.emplace_back();
        row.result.status = answer.result.status;
        row.microseconds = answer.microseconds;
    }
    fmt::print("{}",
               summaryText({.answers = timed,
                            .badRows = 0,
                            .warm = false,
                            .loadSeconds = world.seconds,
                            .buildSeconds = 0.0,
                            .wallSeconds = wall}));
}

int answerTable(const ArticulatedArguments& a,
                const World& world,
                const std::vector<ArticulatedQuery>& queries)
{
    const Stopwatch watch;
    const StopRequest stop(a.timeLimit);
    const std::size_t total = queries.size() * static_cast<std::size_t>(a.repeat);
    std::size_t count = 0;
    std::vector<ArticulatedAnswer> answers;
    ToiOptions options = a.toi;
    options.stop = stop.condition();
    {
        ProgressLine progress(total, "queries");
        answers = runArticulated(world.links,
                                 world.bodies,
                                 queries,
                                 options,
                                 a.repeat,
                                 [&](std::size_t done)
                                 {
                                     count = done;
                                     progress.show(done);
                                     return !stop.isDue();
                                 });
    }
    const double wall = watch.seconds();
    const ArticulatedNames names{.links = world.links, .obstacles = world.obstacles};
    std::string text = articulatedHeader() + "\n";
    for (std::size_t k = 0; k < answers.size(); ++k)
    {
        text += articulatedRow(queries[k].id, answers[k], names) + "\n";
    }
    writeWholeFile(a.output, text);
    if (a.summary)
    {
        printSummary(answers, world, wall);
    }
    return stop.finish("bullet-ccd articulated", count, total, "queries", kDone);
}

/// The arguments with the accuracy that a scene states.
ArticulatedArguments withAccuracyOfScene(ArticulatedArguments a)
{
    std::optional<double> stated;
    if (a.toi.anyWithin || a.toi.tolerance != kDefaultTolerance)
    {
        stated = a.toi.tolerance;
    }
    if (const std::optional<double> accuracy = accuracyOf(a.obstacles, stated))
    {
        a.toi.tolerance = *accuracy;
        a.toi.anyWithin = true;
    }
    return a;
}

int answer(const ArticulatedArguments& given)
{
    checkUsage(given);
    const ArticulatedArguments a = withAccuracyOfScene(given);
    if (!a.output.empty())
    {
        requireOtherFile(a.output, {a.urdf, a.srdf, a.from, a.to, a.path});
        requireWritable(a.output);
    }
    World world = loadRobot(a);
    const KinematicTree& tree = world.links.robot.tree;
    const std::vector<ArticulatedQuery> queries =
        a.path.empty() ? pairQueries(a, tree) : pathQueries(a, tree);
    loadSurroundings(a, queries, world);
    if (a.output.empty())
    {
        return answerOne(a, world, queries[0]);
    }
    return answerTable(a, world, queries);
}

constexpr const char* kArticulatedFooter =
    "The first line of a file of joint positions names joints. Each other line is a configuration "
    "[rad or m]. There may also be the columns id, time (not used), and base_qw base_qx base_qy "
    "base_qz base_tx base_ty base_tz, the pose of the root. Joints without a column rest. "
    "Positions "
    "change linearly over t = 0 to 1; turns are not wrapped.\n"
    "\n"
    "An obstacle is a mesh at the origin, or a scene. A scene in CSV has one obstacle per row, "
    "with "
    "the columns mesh (relative to the scene) and, as needed, name, scale, qw qx qy qz tx ty tz. A "
    "scene in YAML has a list 'obstacles:' of items with the keys mesh, name, scale, position "
    "[tx, ty, tz], and quaternion [qw, qx, qy, qz] or rpy [roll, pitch, yaw]; its key 'accuracy' "
    "stands for --accuracy. Of a manifest "
    "('bullet-ccd manifest') only the meshes are loaded whose boxes the motion meets.\n"
    "\n"
    "--self tests links against each other, except for the pairs that the SRDF disables. Links "
    "that "
    "are joined overlap about their joint by design: triangles that come within --joint-reach of "
    "the other link, somewhere within the limits of the joint, are exempt. The rest of both links "
    "is tested.\n"
    "\n"
    "With -o, --path asks for the motion from every row to the next and writes a row of RESULTS "
    "for "
    "each, named by the row that it starts from. --from and --to of n rows each ask n queries.\n"
    "\n"
    "After Ctrl-C, or at the time limit, RESULTS has the rows of the queries that were answered "
    "and of the one that was stopped in the middle, which is free until its toi. The last line on "
    "stderr says how many were answered.\n"
    "\n"
    "Exit codes: 0 if the queries were answered, whatever the answers are, 130 if RESULTS was "
    "written after Ctrl-C, 2 for wrong options, 3 for bad input.\n"
    "\n"
    "Example:\n"
    "  bullet-ccd articulated arm.urdf --srdf arm.srdf --self \\\n"
    "      --obstacles table.stl shelf.csv --path trajectory.csv -o results.csv";

void addMotionOptions(CLI::App& command, ArticulatedArguments& a)
{
    const auto add = [&](const char* name, std::string& value, const char* text, const char* type)
    { return command.add_option(name, value, text)->type_name(type)->group("Motion"); };
    add("--from", a.from, "The joint positions at t = 0.", "CSV");
    add("--to", a.to, "The joint positions at t = 1.", "CSV");
    add("--path",
        a.path,
        "Instead of --from and --to: configurations, of which each asks a query to the next.",
        "CSV");
    const char* pose = "QW,QX,QY,QZ,TX,TY,TZ";
    add("--base-from", a.baseFrom, "The pose of the root at t = 0. Default: the identity.", pose)
        ->check(parsedBy(poseFromText));
    add("--base-to", a.baseTo, "The pose of the root at t = 1. Default: as at t = 0.", pose)
        ->check(parsedBy(poseFromText));
}

void addWorldOptions(CLI::App& command, ArticulatedArguments& a)
{
    command.add_option("--obstacles", a.obstacles, "Meshes, and scenes of meshes (.csv, .yaml).")
        ->type_name("FILE...")
        ->group("What it may touch");
    command.add_flag("--self", a.self, "Test the links against each other.")
        ->group("What it may touch");
    command.add_option("--srdf", a.srdf, "With --self: which pairs of links not to test.")
        ->type_name("SRDF")
        ->group("What it may touch");
    command
        .add_option("--joint-reach",
                    a.jointReach,
                    "With --self: how near triangles of joined links must come to each other, at a "
                    "position within the limits of the joint, to be exempt [m].")
        ->type_name("D")
        ->check(within(0.0, 1e6))
        ->capture_default_str()
        ->group("What it may touch");
}

void addAnswerOptions(CLI::App& command, ArticulatedArguments& a)
{
    command
        .add_option("--contacts",
                    a.contacts,
                    "Follow the motion beyond the first contact, and show up to N contacts. At "
                    "each of them joints stop, and the others move on.")
        ->type_name("N")
        ->check(within(1, 1'000'000))
        ->capture_default_str()
        ->group("Answer");
    command
        .add_option("--stop",
                    a.rule,
                    "What stops at a contact. chain: all joints up to the root or the common link. "
                    "joint: the nearest joint that moves.")
        ->type_name("NAME")
        ->transform(
            wordFor<StopRule>({{"chain", StopRule::Chain}, {"joint", StopRule::NearestJoint}}))
        ->default_str("chain")
        ->group("Answer");
    command.add_flag("--json", a.json, "Print one JSON object with all digits.")->group("Answer");
    command
        .add_option(
            "-o,--output", a.output, "Where to write RESULTS, a table with one row per query.")
        ->type_name("CSV")
        ->group("Answer");
    command
        .add_option(
            "--repeat",
            a.repeat,
            "With -o: how often to pass over all queries. The time of a query is its median.")
        ->type_name("K")
        ->check(within(1, 10'000))
        ->capture_default_str()
        ->group("Answer");
    command.add_flag("--summary", a.summary, "With -o: print counts and times when all is done.")
        ->group("Answer");
    addTimeLimitOption(command, a.timeLimit, "Stop the queries");
}
}  // namespace

void addArticulatedCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand(
        "articulated", "Finds the first contacts of a robot with obstacles and with itself.");
    command->footer(kArticulatedFooter);
    const auto arguments = std::make_shared<ArticulatedArguments>();
    command->add_option("ROBOT", arguments->urdf, "The robot: URDF, xacro or MJCF.")
        ->type_name("ROBOT")
        ->required();
    addMotionOptions(*command, *arguments);
    addWorldOptions(*command, *arguments);
    addToiOptions(*command, arguments->toi);
    addAnswerOptions(*command, *arguments);
    command->callback([arguments, &exitCode] { exitCode = answer(*arguments); });
}
}  // namespace bullet_ccd::tools
