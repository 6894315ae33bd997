#include "tools/grasp_cli/options/robot_options.h"

#include "bullet_ccd/io/robot_file.h"
#include "tools/grasp_cli/inputs/task_scene.h"
#include "tools/support/option_values.h"
#include "tools/support/pose_text.h"

#include <span>
#include <vector>

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
        .add_option(
            "--hand", arguments.hand, "The hand at its end: a file, or the name of one that ships.")
        ->type_name("HAND")
        ->required();
    command
        .add_option("--srdf", arguments.srdf, "The SRDF of the hand. Default: the one beside it.")
        ->type_name("SRDF");
    addMountOptions(command, arguments);
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

LoadedRobot loadRobot(const RobotArguments& arguments)
{
    LoadedRobot loaded{.hand = loadNamedHand(arguments.hand, arguments.srdf), .robot = {}};
    loaded.robot = mountedOn(arguments, loaded.hand.hand);
    return loaded;
}
}  // namespace bullet_ccd::tools
