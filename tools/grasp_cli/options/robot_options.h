/// Which arm carries which hand.
#pragma once

#include "grasp/task/arm_robot.h"
#include "tools/grasp_cli/inputs/catalogue.h"

#include <CLI/CLI.hpp>
#include <array>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct RobotArguments
{
    std::string arm;
    std::string hand;
    std::string srdf;
    std::string flange;
    std::string mount;
    std::vector<std::string> handLinks;  ///< with which the hands of the arm's file begin
};

/// The pose QW,QX,QY,QZ,TX,TY,TZ. Throws as numbersFrom() and poseFrom().
[[nodiscard]] Eigen::Isometry3d poseFromText(const std::string& text);

/// --arm, --hand, --srdf, --flange, --mount and --hand-link.
void addRobotOptions(CLI::App& command, RobotArguments& arguments);
/// --flange and --mount.
void addMountOptions(CLI::App& command, RobotArguments& arguments);

/// The arm with a hand that is loaded already. Throws as loadRobot() and mountHand().
[[nodiscard]] grasp::ArmRobot mountedOn(const RobotArguments& arguments,
                                        const grasp::HandModel& hand);

/// The robot refers to the hand, which may be moved.
struct LoadedRobot
{
    LoadedHand hand;
    grasp::ArmRobot robot;
};
/// Composed of two files, or split where only the arm is given.
/// Throws as loadRobot(), loadNamedHand(), mountHand(), findHandRoots() and splitRobot().
[[nodiscard]] LoadedRobot loadRobot(const RobotArguments& arguments);

/// The left arm and the right one of a robot with two hands; the hand is not given. Throws as
/// loadRobot() and splitArms().
[[nodiscard]] std::array<LoadedRobot, 2> loadTwoArms(const RobotArguments& arguments);
}  // namespace bullet_ccd::tools
