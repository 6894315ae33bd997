#include "bullet_ccd/contact/rigid_contacts.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/support/pose_text.h"
#include "tools/ccd_cli/run/query_run.h"
#include "tools/ccd_cli/text/result_text.h"
#include "tools/support/option_values.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
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

struct ToiArguments
{
    std::string fileA;
    std::string fileB;
    BodyArguments bodyA;
    BodyArguments bodyB;
    bool screw = false;
    bool json = false;
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

RigidMotion motionOf(const BodyArguments& body, bool screw)
{
    const Eigen::Isometry3d start = poseOf(body.start);
    if (!body.end.empty())
    {
        const Eigen::Isometry3d end = poseOf(body.end);
        return screw ? screwBetween(start, end) : motionBetween(start, end);
    }
    return {.X_W0 = start, .v_W = vectorOf(body.velocity), .w_W = vectorOf(body.angular)};
}

void addBody(CLI::App& command, const std::string& name, BodyArguments& body)
{
    const std::string group = name == "a" ? "Motion of A" : "Motion of B";
    const auto add = [&](const std::string& option, std::string& value, const std::string& text)
    { return command.add_option("--" + name + option, value, text)->group(group); };
    add("0", body.start, "pose at t = 0; default identity")
        ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
        ->check(parsedBy(poseOf));
    CLI::Option* end = add("1", body.end, "pose at t = 1; default by the velocities")
                           ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
                           ->check(parsedBy(poseOf));
    add("-velocity", body.velocity, "of the origin, mesh units per interval, world axes")
        ->type_name("VX,VY,VZ")
        ->check(parsedBy(vectorOf))
        ->excludes(end);
    add("-angular", body.angular, "rad per interval, world axes, any number of turns")
        ->type_name("WX,WY,WZ")
        ->check(parsedBy(vectorOf))
        ->excludes(end);
}

void answer(const ToiArguments& arguments)
{
    if (arguments.screw && arguments.bodyA.end.empty() && arguments.bodyB.end.empty())
    {
        throw CLI::ValidationError("--motion", "a screw leads to an end pose: give --a1 or --b1");
    }
    const std::array<RigidQuery, 1> query{
        RigidQuery{.id = "",
                   .motionA = motionOf(arguments.bodyA, arguments.screw),
                   .motionB = motionOf(arguments.bodyB, arguments.screw)}};
    const MeshPair meshes = loadMeshPair(arguments.fileA, arguments.fileB);
    const std::vector<TimedAnswer> answers =
        runQueries(*meshes.treeA, *meshes.treeB, query, {.toi = arguments.toi}, [](std::size_t) {});
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
}
}  // namespace

void addToiCommand(CLI::App& app)
{
    CLI::App* command = app.add_subcommand("toi", "first contact of two moving bodies");
    command->footer(
        "Without options a body rests at the origin. The motion between poses takes the shortest "
        "arc;\n"
        "at a half turn, where there are two, the axis whose first component is positive.\n"
        "\n"
        "Example, a cube that falls on a plate and turns once:\n"
        "  bullet-ccd toi cube.obj plate.obj --a0 1,0,0,0,0,0,2 --a-velocity 0,0,-4 "
        "--a-angular 0,0,6.2832");
    const auto arguments = std::make_shared<ToiArguments>();
    command->add_option("A", arguments->fileA, "mesh of body A")->type_name("MESH")->required();
    command->add_option("B", arguments->fileB, "mesh of body B")->type_name("MESH")->required();
    addBody(*command, "a", arguments->bodyA);
    addBody(*command, "b", arguments->bodyB);
    command
        ->add_option_function<std::string>(
            "--motion",
            [arguments](const std::string& text) { arguments->screw = text == "screw"; },
            "between poses: linear (origin on a line) or screw")
        ->type_name("NAME")
        ->check(oneOf({"linear", "screw"}))
        ->default_str("linear");
    addToiOptions(*command, arguments->toi);
    command->add_flag(
        "--json", arguments->json, "print one JSON object with all digits and contacts");
    command->callback([arguments] { answer(*arguments); });
}
}  // namespace bullet_ccd::tools
