/// The option --effort: torque limits of joints, in place of what the URDF says.
#pragma once

#include "bullet_ccd/io/robot_file.h"
#include "grasp/force/grasp_forces.h"

#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct Effort
{
    std::string joint;  ///< empty: all
    double limit = 0.0;
};

/// "E" or "JOINT=E"; 0 becomes infinity, as in a URDF.
/// Throws std::invalid_argument for anything else.
[[nodiscard]] Effort parseEffort(const std::string& text);

/// The same, but 0 is none: of what has to press.
[[nodiscard]] Effort parseOwnEffort(const std::string& text);

/// Sets the limits of the problem in the order given.
/// Throws std::runtime_error for a joint that the robot does not have, or that follows another one.
void applyEfforts(const std::vector<std::string>& texts,
                  const RobotModel& robot,
                  grasp::ForceProblem& problem);
}  // namespace bullet_ccd::tools
