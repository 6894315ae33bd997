#include "tools/grasp_cli/options/robot_options.h"

#include "bullet_ccd/io/robot_file.h"
#include "grasp/task/split_robot.h"
#include "tools/grasp_cli/inputs/task_scene.h"
#include "tools/support/option_values.h"
#include "tools/support/pose_text.h"
#include "tools/support/text_table.h"

#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
Eigen::Isometry3d poseFromText(const std::string& text)
{
    const std::vector<double> values = numbersFrom(text, 7);
    return poseFrom(std::span<const double, 7>(values.data(), 7));
}

void addRobotOptions(CLI::App& command, RobotArguments& arguments)
{
    command
        .add_option(
            "--arm", arguments.arm, "A URDF, xacro or MJCF file, or the name of an arm that ships.")
        ->type_name("ARM")
        ->required();
    command
        .add_option("--hand",
                    arguments.hand,
                    "The hand at its end: a file, or the name of one that ships. Default: the hand "
                    "that is a "
                    "part of the arm's file.")
        ->type_name("HAND");
    command
        .add_option("--srdf",
                    arguments.srdf,
                    "The SRDF of the hand, or of the arm with it. Default: the one beside it.")
        ->type_name("SRDF");
    addMountOptions(command, arguments);
    command
        .add_option(
            "--hand-link",
            arguments.handLinks,
            "Without --hand: the link with which the hand begins; of two hands, both. Default: "
            "by the end effectors of the SRDF, or where the chain divides into fingers.")
        ->type_name("LINK")
        ->delimiter(',');
}

void addMountOptions(CLI::App& command, RobotArguments& arguments)
{
    command
        .add_option(
            "--flange", arguments.flange, "The link that carries the hand. Default: the arm's end.")
        ->type_name("LINK");
    command
        .add_option("--mount",
                    arguments.mount,
                    "The pose of the hand's root link in it. Default: the identity.")
        ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
        ->check(parsedBy(poseFromText));
}

grasp::ArmRobot mountedOn(const RobotArguments& arguments, const grasp::HandModel& hand)
{
    return grasp::mountHand(
        bullet_ccd::loadRobot(resolveArm(arguments.arm)),
        hand,
        arguments.flange,
        arguments.mount.empty() ? Eigen::Isometry3d::Identity() : poseFromText(arguments.mount));
}

namespace
{
/// An arm with its hand or hands, of one file.
struct WholeRobot
{
    RobotModel model;
    std::optional<std::filesystem::path> srdf;
    std::vector<std::int32_t> handRoots;
};

/// With as many hands as are wanted.
WholeRobot wholeRobot(const RobotArguments& arguments, std::size_t hands)
{
    if (!arguments.flange.empty() || !arguments.mount.empty())
    {
        throw std::runtime_error("--flange and --mount place the hand of --hand: give it, too");
    }
    WholeRobot whole{.model = bullet_ccd::loadRobot(
                         std::filesystem::absolute(resolveArm(arguments.arm)).lexically_normal()),
                     .srdf = {},
                     .handRoots = {}};
    std::filesystem::path beside = whole.model.file;
    beside.replace_extension(".srdf");
    if (!arguments.srdf.empty())
    {
        whole.srdf = std::filesystem::absolute(arguments.srdf).lexically_normal();
    }
    else if (std::filesystem::is_regular_file(beside))
    {
        whole.srdf = beside;
    }
    whole.handRoots = grasp::findHandRoots(whole.model, whole.srdf, arguments.handLinks);
    if (whole.handRoots.size() != hands)
    {
        std::vector<std::string> names;
        for (const std::int32_t root : whole.handRoots)
        {
            names.push_back(whole.model.tree.links[static_cast<std::size_t>(root)].name);
        }
        throw std::runtime_error(fmt::format(
            "{}: {} hand{} found, where {} wanted: {}: give {}",
            whole.model.file.string(),
            names.size(),
            names.size() == 1 ? " was" : "s were",
            hands == 1 ? "one is" : "two are",
            joined(names, ", "),
            hands == 1 ? "--hand-link with one of them, or --hand"
                       : "--hand-link with two links, or --hand for two arms of a kind"));
    }
    return whole;
}

LoadedRobot mounted(grasp::SplitRobot split, const WholeRobot& whole)
{
    LoadedRobot loaded{
        .hand = {.hand = grasp::handOf(
                     std::move(split.hand), whole.model.tree, whole.srdf, cacheFolder()),
                 .file = whole.model.file},
        .robot = {}};
    loaded.robot = grasp::mountHand(split.arm, loaded.hand.hand, split.flange, split.X_FH);
    loaded.robot.name = split.arm.name;
    return loaded;
}
}  // namespace

LoadedRobot loadRobot(const RobotArguments& arguments)
{
    if (arguments.hand.empty())
    {
        const WholeRobot whole = wholeRobot(arguments, 1);
        return mounted(grasp::splitRobot(whole.model, whole.handRoots.front()), whole);
    }
    if (!arguments.handLinks.empty())
    {
        throw std::runtime_error(
            "--hand-link says where the hand of the arm's file begins: leave out --hand, or it");
    }
    LoadedRobot loaded{.hand = loadNamedHand(arguments.hand, arguments.srdf), .robot = {}};
    loaded.robot = mountedOn(arguments, loaded.hand.hand);
    return loaded;
}

std::array<LoadedRobot, 2> loadTwoArms(const RobotArguments& arguments)
{
    const WholeRobot whole = wholeRobot(arguments, 2);
    std::array<grasp::SplitRobot, 2> arms =
        grasp::splitArms(whole.model, {whole.handRoots[0], whole.handRoots[1]});
    return {mounted(std::move(arms[0]), whole), mounted(std::move(arms[1]), whole)};
}
}  // namespace bullet_ccd::tools
