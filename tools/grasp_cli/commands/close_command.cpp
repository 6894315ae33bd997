#include "grasp/check/penetration_check.h"
#include "grasp/closing/swept_boxes.h"
#include "grasp/formats/content_hash.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/quality/object_mass.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/inputs/path_file.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/grasp_cli/options/planner_options.h"
#include "tools/grasp_cli/options/squeeze_options.h"
#include "tools/grasp_cli/plan/plan_outputs.h"
#include "tools/grasp_cli/plan/plan_run.h"
#include "tools/support/obstacles/obstacle_list.h"
#include "tools/support/pose_text.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::Grasp;
using grasp::RejectReason;

struct CloseArguments
{
    PairOptions pair;
    std::vector<double> pose;      ///< x y z qw qx qy qz; empty: there is a path
    std::vector<double> approach;  ///< dx dy dz distance; empty: none
    std::string path;              ///< file; empty: none
    std::vector<std::string> scene;
    std::string preshape;  ///< empty: the hand's first
    std::string output;
    bool json = false;
    bool boxes = false;
    bool quiet = false;
    SqueezeArguments squeeze;
    grasp::PlannerOptions options;
};

/// What is wrong with the numbers themselves is an error of usage.
Eigen::Isometry3d poseOf(const CloseArguments& arguments)
{
    const std::vector<double>& p = arguments.pose;
    try
    {
        return poseFrom(std::array{p[3], p[4], p[5], p[6], p[0], p[1], p[2]});
    }
    catch (const std::invalid_argument& error)
    {
        throw CLI::ValidationError("--pose", error.what());
    }
}

Eigen::Vector3d shiftOf(const CloseArguments& arguments)
{
    if (arguments.approach.empty())
    {
        return Eigen::Vector3d::Zero();
    }
    const std::vector<double>& a = arguments.approach;
    const Eigen::Vector3d direction(a[0], a[1], a[2]);
    if (direction.norm() < 1e-9 || a[3] <= 0.0)
    {
        throw CLI::ValidationError(
            "--approach", "the direction must not be zero, and the distance must be positive");
    }
    return a[3] * direction.normalized();
}

/// How the hand gets to where it closes.
struct HandWay
{
    Eigen::Isometry3d X_WStart = Eigen::Isometry3d::Identity();
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    std::vector<Eigen::Isometry3d> path{};  ///< instead, if not empty
};

HandWay wayOf(const CloseArguments& arguments)
{
    if (!arguments.path.empty())
    {
        return {.path = readPathFile(arguments.path)};
    }
    if (arguments.pose.empty())
    {
        throw CLI::RequiredError("--pose or --path");
    }
    return {.X_WStart = poseOf(arguments), .shift = shiftOf(arguments)};
}

/// Boxes in W about all that the hand passes through on its way and while it closes.
std::vector<Eigen::AlignedBox3d> reachOf(const HandWay& way,
                                         const grasp::HandModel& hand,
                                         const grasp::Preshape& preshape,
                                         const grasp::ClosingOptions& closing)
{
    const grasp::SweptBoxes boxes = grasp::sweptBoxes(hand, preshape.positions);
    const Eigen::Vector3d wider = Eigen::Vector3d::Constant(2.0 * closing.tolerance + 1e-6);
    std::vector<Eigen::AlignedBox3d> reach;
    const auto add = [&](const Eigen::AlignedBox3d& box)
    { reach.emplace_back(box.min() - wider, box.max() + wider); };
    double radius = 0.0;  // about the root's origin
    for (const Eigen::AlignedBox3d& box : boxes.closing)
    {
        if (!box.isEmpty())
        {
            radius = std::max(radius, box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm());
            if (way.path.empty())
            {
                add(grasp::sweptAlong(box.transformed(way.X_WStart), way.shift));
            }
        }
    }
    for (std::size_t leg = 0; leg < way.path.size(); ++leg)
    {
        // The hand may turn on a leg, and its origin moves straight.
        Eigen::AlignedBox3d origin(way.path[leg].translation());
        origin.extend(way.path[leg > 0 ? leg - 1 : 0].translation());
        const Eigen::Vector3d around = Eigen::Vector3d::Constant(radius);
        add({origin.min() - around, origin.max() + around});
    }
    return reach;
}

grasp::PathGrasp closeAfter(const HandWay& way,
                            const LoadedHand& hand,
                            const LoadedObject& object,
                            const grasp::Preshape& preshape,
                            const grasp::PlannerOptions& options,
                            std::span<const RigidBody> obstacles,
                            ClosingUses& uses)
{
    const grasp::CloseHand engine =
        closingEngine(options.engine, obstacles, hasAccuracy(options) ? &uses : nullptr)();
    if (!way.path.empty())
    {
        return closeOnPath(
            hand.hand, object.object, way.path, preshape, options, engine, obstacles);
    }
    return {.way = {},
            .grasp = closeAtPose(hand.hand,
                                 object.object,
                                 way.X_WStart,
                                 way.shift,
                                 preshape,
                                 options,
                                 engine,
                                 obstacles)};
}

const grasp::Preshape& preshapeOf(const CloseArguments& arguments, const LoadedHand& hand)
{
    const std::vector<grasp::Preshape>& known = hand.hand.preshapes;
    if (arguments.preshape.empty())
    {
        return known.front();
    }
    if (const auto* found = grasp::findPreshape(hand.hand, arguments.preshape); found != nullptr)
    {
        return *found;
    }
    std::vector<std::string> names;
    for (const grasp::Preshape& preshape : known)
    {
        names.push_back(preshape.name);
    }
    throw std::runtime_error(fmt::format("{}: no preshape \"{}\": the hand has {}",
                                         hand.file.string(),
                                         arguments.preshape,
                                         joined(names, ", ")));
}

std::string stopsText(const grasp::HandModel& hand, const Grasp& grasp)
{
    TextTable table{.header = {"stopped", "time [s]", "by"}, .rows = {}};
    for (const grasp::StopEvent& stop : grasp.stops)
    {
        table.rows.push_back({linkName(hand, stop.link),
                              fmt::format("{:.4f}", stop.time),
                              stop.byObject ? "object" : "hand"});
    }
    return alignedText(table);
}

std::string jointsText(const grasp::HandModel& hand, const Grasp& grasp)
{
    TextTable table{.header = {"joint", "position", "unit"}, .rows = {}};
    for (std::size_t link = 1; link < grasp.positions.size(); ++link)
    {
        const Joint& joint = hand.robot.tree.links[link].joint;
        if (joint.isMovable())
        {
            table.rows.push_back({joint.name,
                                  fmt::format("{:.6f}", grasp.positions[link]),
                                  joint.type == JointType::Prismatic ? "m" : "rad"});
        }
    }
    return alignedText(table);
}

std::string contactsText(const grasp::HandModel& hand, const Grasp& grasp)
{
    TextTable table{
        .header = {"contact of", "x [m]", "y [m]", "z [m]", "nx", "ny", "nz", "gap [mm]"},
        .rows = {}};
    for (const grasp::GraspContact& contact : grasp.contacts)
    {
        std::vector<std::string> row = {linkName(hand, contact.link)};
        for (const double coordinate : contact.point)
        {
            row.push_back(fmt::format("{:.5f}", coordinate));
        }
        for (const double coordinate : contact.normal)
        {
            row.push_back(fmt::format("{:.4f}", coordinate));
        }
        row.push_back(fmt::format("{:.4f}", 1e3 * contact.gap));
        table.rows.push_back(std::move(row));
    }
    return alignedText(table);
}

/// Why nothing is held; empty if something is.
std::string failureOf(const grasp::HandModel& hand,
                      const grasp::GraspObject& object,
                      const Grasp& grasp)
{
    const auto intersecting = [&](const std::vector<double>& positions)
    {
        const std::int32_t link = grasp::checkPenetration(hand, object, grasp.X_WH, positions).link;
        return link == kNone ? std::string("it") : "link " + linkName(hand, link);
    };
    switch (grasp.reject)
    {
        case RejectReason::OverlapAtStart:
            return fmt::format(
                "overlap at start: {} intersects the object: move the pose away or start from "
                "another preshape",
                intersecting(grasp::findPreshape(hand, grasp.preshape)->positions));
        case RejectReason::SelfOverlap:
            return fmt::format("self overlap: links of the hand intersect in preshape {}",
                               grasp.preshape);
        case RejectReason::IterationLimit:
            return "a time-of-impact query gave up";
        case RejectReason::Penetration:
            return fmt::format("penetration: {} intersects the object after closing",
                               intersecting(grasp.positions));
        default:
            return grasp.contacts.empty() ? "nothing touched: no link reached the object" : "";
    }
}

/// Empty for a hand that could not set out.
std::string pathText(const grasp::PathApproach& way)
{
    if (way.status == ToiStatus::Overlapping)
    {
        return {};
    }
    const std::string end =
        isContact(way.status) ? fmt::format("a contact at {:.4f} of leg {}", way.time, way.leg + 1)
                              : "its end";
    return fmt::format("followed the path for {:.3f} mm, to {}\n\n", 1e3 * way.length, end);
}

void printGrasp(const CloseArguments& arguments, const grasp::HandModel& hand, const Grasp& grasp)
{
    if (!arguments.approach.empty())
    {
        fmt::print("approached by {:.3f} mm\n\n", 1e3 * grasp.approachDistance);
    }
    if (grasp.positions.empty())
    {
        return;
    }
    fmt::print("{}\n{}\n", stopsText(hand, grasp), jointsText(hand, grasp));
    if (grasp.contacts.empty())
    {
        return;
    }
    fmt::print("{}\nepsilon {:.4f}, volume {:.3g}: {} (mu {:g}, epsilon >= {:g})\n",
               contactsText(hand, grasp),
               grasp.quality.epsilon,
               grasp.quality.volume,
               grasp.quality.forceClosure ? "force closure" : "no force closure",
               arguments.options.friction,
               arguments.options.forceClosureThreshold);
    if (grasp.reject != RejectReason::Penetration)
    {
        fmt::print("no penetration, by the independent check\n");
    }
}

int close(CloseArguments arguments)
{
    setAccuracyOfScenes(arguments.options.closing, arguments.scene);
    const HandWay way = wayOf(arguments);
    const LoadedHand hand = loadHandOf(arguments.pair);
    requireFingers(hand, arguments.options.closing);
    const LoadedObject object = loadObjectOf(arguments.pair);
    const grasp::Preshape& preshape = preshapeOf(arguments, hand);
    std::optional<OutputFolder> output;
    if (!arguments.output.empty())
    {
        output.emplace(arguments.output);
    }
    if (!arguments.quiet)
    {
        printNotes(hand, object);
    }
    const ObstacleList obstacles = loadObstaclesWithin(
        arguments.scene, reachOf(way, hand.hand, preshape, arguments.options.closing));
    requireKinematic(obstacles.inReach, arguments.options);
    const std::vector<RigidBody> bodies = bodiesOf(obstacles.inReach);
    SqueezeArguments squeeze = arguments.squeeze;
    squeeze.mass = grasp::massOf(object.object, arguments.options.mass).mass;
    const grasp::GraspRun run{
        .handFile = hand.file,
        .srdfFile = hand.hand.srdfFile,
        .objectFile = object.file,
        .objectScale = arguments.pair.objectScale,
        .obstaclesHash = grasp::contentHash(bodies),
        .options = arguments.options,
        .squeeze = squeezeOptionsOf(squeeze, arguments.options.friction, hand.hand)};
    ClosingUses uses;
    const grasp::PathGrasp closed =
        closeAfter(way, hand, object, preshape, arguments.options, bodies, uses);
    const std::vector<Grasp> grasps = {closed.grasp};
    const std::string failure = failureOf(hand.hand, object.object, grasps.front());
    if (arguments.json)
    {
        grasp::writeGrasps(std::cout, run, hand.hand, object.object, grasps);
    }
    else
    {
        if (!way.path.empty())
        {
            fmt::print("{}", pathText(closed.way));
        }
        printGrasp(arguments, hand.hand, grasps.front());
        if (obstacles.outOfReach > 0)
        {
            fmt::print("obstacles out of reach, not loaded: {} of {}\n",
                       obstacles.outOfReach,
                       obstacles.outOfReach + obstacles.inReach.size());
        }
        if (!uses.empty())
        {
            fmt::print("closing needed {}\n",
                       plainText(closingShare(uses, hand.hand, object.object, obstacles)));
        }
    }
    if (output)
    {
        const std::vector<std::string> written = writePlanOutputs(*output,
                                                                  run,
                                                                  hand.hand,
                                                                  object.object,
                                                                  grasps,
                                                                  {.pictures = 1,
                                                                   .models = 1,
                                                                   .sweptBoxes = arguments.boxes,
                                                                   .scene = arguments.scene,
                                                                   .uses = &uses,
                                                                   .obstacles = &obstacles},
                                                                  bodies);
        if (!arguments.json)
        {
            fmt::print("written:  {}\n", joined(written, "\n          "));
        }
    }
    if (!failure.empty())
    {
        fmt::print(stderr, "grasp close: {}\n", failure);
    }
    return failure.empty() ? kDone : kNothingFound;
}
}  // namespace

void addCloseCommand(CLI::App& app, int& exitCode)
{
    auto* command =
        app.add_subcommand("close", "Closes the hand at one pose and scores what it holds.");
    const auto arguments = std::make_shared<CloseArguments>();
    arguments->options.candidates = 1;
    addPairOptions(*command, arguments->pair);
    addSceneOption(*command, arguments->scene);
    auto* pose = command
                     ->add_option("--pose",
                                  arguments->pose,
                                  "The pose of the root link of the hand in the frame of the "
                                  "object [m]: position, then unit "
                                  "quaternion.")
                     ->type_name("X Y Z QW QX QY QZ")
                     ->expected(7)
                     ->check(within(-kFar, kFar))
                     ->group("Pose");
    command
        ->add_option("--approach",
                     arguments->approach,
                     "First move the open hand along the direction DX DY DZ until its first "
                     "contact, or by the "
                     "distance D [m], and close there.")
        ->type_name("DX DY DZ D")
        ->expected(4)
        ->check(within(-kFar, kFar))
        ->needs(pose)
        ->group("Pose");
    command
        ->add_option("--path",
                     arguments->path,
                     "Instead of a pose: a CSV file of poses x,y,z,qw,qx,qy,qz, one per row. The "
                     "open hand moves "
                     "from each to the next until its first contact, or the end, and closes there.")
        ->type_name("FILE")
        ->excludes(pose)
        ->group("Pose");
    command
        ->add_option("--preshape",
                     arguments->preshape,
                     "The preshape to close from. Default: the first of the hand.")
        ->type_name("NAME")
        ->group("Pose");
    command
        ->add_flag("--centred",
                   arguments->options.centred,
                   "Let jaws on one motor that touch on one side go sideways, as a plan does.")
        ->group("Pose");
    addEngineOption(*command, arguments->options);
    addFingersOption(*command, arguments->options.closing);
    addQualityOptions(*command, arguments->options);
    addSqueezeOptions(*command, arguments->squeeze);
    command
        ->add_flag(
            "--json", arguments->json, "Print one record as in grasps.jsonl instead of tables.")
        ->group("Output");
    command
        ->add_option("-o,--output",
                     arguments->output,
                     "A folder for the same files that plan writes. Default: none.")
        ->type_name("FOLDER")
        ->group("Output");
    command->add_flag("--boxes", arguments->boxes, "Also draw the boxes that links sweep.")
        ->group("Output");
    command->add_flag("-q,--quiet", arguments->quiet, "Print no notes on stderr.")->group("Output");
    command->footer(
        "Exit codes: 0 if the hand closed with contacts, 1 if nothing touched or something "
        "overlaps "
        "(stderr says which), 2 for wrong options, 3 for bad input.\n"
        "\n"
        "Examples:\n"
        "  grasp close --hand parallel_gripper --object box.obj \\\n"
        "      --pose 0 0 -0.13 1 0 0 0\n"
        "  grasp close --hand parallel_gripper --object box.obj \\\n"
        "      --pose 0 0 -0.3 1 0 0 0 --approach 0 0 1 0.2 -o out");
    command->callback([arguments, &exitCode] { exitCode = close(*arguments); });
}
}  // namespace bullet_ccd::tools
