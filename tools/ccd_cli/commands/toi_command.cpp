#include "bullet_ccd/contact/contacts.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/ccd_cli/run/query_run.h"
#include "tools/ccd_cli/text/result_text.h"
#include "tools/support/command_line.h"
#include "tools/support/obstacles/needed_picture.h"
#include "tools/support/option_values.h"
#include "tools/support/pose_text.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_file.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
struct BodyArguments
{
    std::string start = "1,0,0,0,0,0,0";
    std::string end;  ///< empty: twist or rest
    std::string velocity = "0,0,0";
    std::string angular = "0,0,0";
};

/// How a body gets from one pose to the other.
enum class PathKind
{
    Linear,
    Screw,
};

struct ToiArguments
{
    std::string fileA;
    std::string fileB;
    BodyArguments bodyA;
    BodyArguments bodyB;
    PathKind motion = PathKind::Linear;
    bool json = false;
    std::string picture;  ///< file; empty: none
    double timeLimit = 0.0;
    ToiOptions toi;
};

Eigen::Isometry3d poseOf(const std::string& text)
{
    const std::vector<double> numbers = numbersFrom(text, 7);
    std::array<double, 7> values{};
    std::copy(numbers.begin(), numbers.end(), values.begin());
    return poseFrom(values);
}

Eigen::Vector3d vectorOf(const std::string& text)
{
    const std::vector<double> numbers = numbersFrom(text, 3);
    return {numbers[0], numbers[1], numbers[2]};
}

RigidMotion motionOf(const BodyArguments& body, PathKind kind)
{
    const Eigen::Isometry3d start = poseOf(body.start);
    if (!body.end.empty())
    {
        const Eigen::Isometry3d end = poseOf(body.end);
        return kind == PathKind::Screw ? screwBetween(start, end) : motionBetween(start, end);
    }
    return {.X_W0 = start, .v_W = vectorOf(body.velocity), .w_W = vectorOf(body.angular)};
}

void addBody(CLI::App& command, const std::string& name, BodyArguments& body)
{
    const auto add = [&](const std::string& option, std::string& value, const std::string& text)
    {
        return command.add_option("--" + name + option, value, text)
            ->group("Motion of " + std::string(name == "a" ? "A" : "B"));
    };
    add("0", body.start, "The pose at t = 0: a unit quaternion, then the position of the origin.")
        ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
        ->check(parsedBy(poseOf))
        ->capture_default_str();
    CLI::Option* end =
        add("1", body.end, "The pose at t = 1. Without it, the velocities say how the body moves.")
            ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
            ->check(parsedBy(poseOf));
    add("-velocity",
        body.velocity,
        "The velocity of the origin in world axes [unit of the meshes per interval].")
        ->type_name("VX,VY,VZ")
        ->check(parsedBy(vectorOf))
        ->excludes(end)
        ->capture_default_str();
    add("-angular",
        body.angular,
        "The angular velocity in world axes [rad per interval]. The body may turn any number of "
        "times.")
        ->type_name("WX,WY,WZ")
        ->check(parsedBy(vectorOf))
        ->excludes(end)
        ->capture_default_str();
}

/// What the query needs of the meshes; it is asked once more for that.
ModelUse useOf(const MeshPair& meshes, const RigidQuery& query, const ToiOptions& options)
{
    ModelUse use;
    ToiWorkspace work;
    noteModelUse(work, &use);
    static_cast<void>(rigidToi({.tree = meshes.treeA.get(), .motion = query.motionA},
                               {.tree = meshes.treeB.get(), .motion = query.motionB},
                               options,
                               work));
    return use;
}

int answer(const ToiArguments& arguments)
{
    if (arguments.motion == PathKind::Screw && arguments.bodyA.end.empty() &&
        arguments.bodyB.end.empty())
    {
        throw CLI::ValidationError("--motion", "screw leads to a pose at t = 1: give --a1 or --b1");
    }
    const std::array<RigidQuery, 1> query{
        RigidQuery{.id = "",
                   .motionA = motionOf(arguments.bodyA, arguments.motion),
                   .motionB = motionOf(arguments.bodyB, arguments.motion)}};
    if (!arguments.picture.empty())
    {
        requireOtherFile(arguments.picture, {arguments.fileA, arguments.fileB});
        requireWritable(arguments.picture);
    }
    const MeshPair meshes = loadMeshPair(arguments.fileA, arguments.fileB, buildSsvTreeAsNeeded);
    checkAccuracy(arguments.toi, meshes.treeA->mesh());
    checkAccuracy(arguments.toi, meshes.treeB->mesh());
    const StopRequest stop(arguments.timeLimit);
    ToiOptions options = arguments.toi;
    options.stop = stop.condition();
    std::vector<TimedAnswer> answers = runQueries(
        *meshes.treeA, *meshes.treeB, query, {.toi = options}, [](std::size_t) { return true; });
    if (options.anyWithin)
    {
        const ModelUse use = useOf(meshes, query[0], options);
        answers[0].needed = {use, std::array{meshes.treeA.get(), meshes.treeB.get()}};
        if (!arguments.picture.empty())
        {
            const double t = answers[0].result.time;
            writeNeededPicture(
                arguments.picture,
                std::span(&use, 1),
                std::array{DrawnBody{meshes.treeA.get(), query[0].motionA.at(t).X_W},
                           DrawnBody{meshes.treeB.get(), query[0].motionB.at(t).X_W}});
        }
    }
    const ToiResult& result = answers[0].result;
    std::vector<FeatureContact> contacts;
    if (result.status == ToiStatus::Hit || result.status == ToiStatus::TouchingPressing)
    {
        contacts = contactsAt({.tree = meshes.treeA.get(), .motion = query[0].motionA},
                              {.tree = meshes.treeB.get(), .motion = query[0].motionB},
                              result.time,
                              arguments.toi.minimumSeparation + arguments.toi.tolerance);
    }
    fmt::print("{}",
               arguments.json ? jsonText(answers[0], contacts)
                              : readableText(answers[0], arguments.toi, contacts));
    const std::size_t done = result.status == ToiStatus::Stopped ? 0 : 1;
    return stop.finish("bullet-ccd toi", done, 1, "queries", kDone);
}
}  // namespace

void addToiCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand("toi", "Finds the first contact of two moving bodies.");
    command->footer(
        "A body without options rests at the origin. Where the shortest arc between two poses is a "
        "half turn, the axis whose first component is positive is taken.\n"
        "\n"
        "After Ctrl-C, or at the time limit, the answer says up to when the bodies are free.\n"
        "\n"
        "Exit codes: 0 if there is an answer, whatever it is, 130 likewise after Ctrl-C, 2 for "
        "wrong options, 3 for bad input.\n"
        "\n"
        "Example, a cube that falls on a plate and turns once:\n"
        "  bullet-ccd toi cube.obj plate.obj --a0 1,0,0,0,0,0,2 \\\n"
        "      --a-velocity 0,0,-4 --a-angular 0,0,6.2832");
    const auto arguments = std::make_shared<ToiArguments>();
    addMeshes(*command, arguments->fileA, arguments->fileB);
    addBody(*command, "a", arguments->bodyA);
    addBody(*command, "b", arguments->bodyB);
    command
        ->add_option("--motion",
                     arguments->motion,
                     "How a body gets from one pose to the other. linear: its origin "
                     "moves on a straight line, and it turns along the shortest arc at a constant "
                     "rate. screw: it moves along a fixed axis and turns about it.")
        ->type_name("NAME")
        ->transform(wordFor<PathKind>({{"linear", PathKind::Linear}, {"screw", PathKind::Screw}}))
        ->default_str("linear");
    addToiOptions(*command, arguments->toi);
    command->add_flag(
        "--json", arguments->json, "Print one JSON object with all digits and all contacts.");
    command
        ->add_option("--draw",
                     arguments->picture,
                     "With --accuracy: where to write both bodies at the time of the answer, as a "
                     "mesh in which what was looked at closely is orange.")
        ->type_name("PLY")
        ->needs("--accuracy");
    addTimeLimitOption(*command, arguments->timeLimit, "Stop the query");
    command->callback([arguments, &exitCode] { exitCode = answer(*arguments); });
}
}  // namespace bullet_ccd::tools
