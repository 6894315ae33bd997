/// Options of squeezes, shared by `grasp plan`, `grasp trial` and `grasp export`.
#pragma once

#include "bullet_ccd/io/robot_file.h"
#include "grasp/squeeze/squeeze.h"

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct SqueezeArguments
{
    std::optional<double> mass{};
    double firmness = grasp::SqueezeOptions{}.firmness;
    std::vector<std::string> efforts{};
};

/// Adds --firmness and --effort; the commands have --mass, each with its own words.
void addSqueezeOptions(CLI::App& command, SqueezeArguments& arguments);

/// Adds these, and --mass and --friction for what otherwise a plan says.
void addRecordSqueezeOptions(CLI::App& command,
                             std::optional<double>& mass,
                             std::optional<double>& friction,
                             SqueezeArguments& arguments);

/// Throws std::runtime_error for a joint that the robot does not have, or an effort that is 0.
[[nodiscard]] grasp::SqueezeOptions squeezeOptionsOf(const SqueezeArguments& arguments,
                                                     double friction,
                                                     const grasp::HandModel& hand);

/// Names of the joints that move by themselves, in the order of independentJoints().
[[nodiscard]] std::vector<std::string> independentJointNames(const KinematicTree& tree);

/// Efforts that the squeeze assumes, such as "finger=1, thumb=1" or "1 for all joints"; empty if
/// the robot states all.
[[nodiscard]] std::string assumedEfforts(const grasp::SqueezeOptions& options,
                                         const grasp::HandModel& hand);
}  // namespace bullet_ccd::tools
