#include "tools/grasp_cli/options/effort_option.h"

#include "tools/support/option_values.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
/// Column of the joint.
std::size_t findJoint(const std::string& name,
                      const RobotModel& robot,
                      const grasp::ForceProblem& problem)
{
    const auto found = std::find(problem.jointNames.begin(), problem.jointNames.end(), name);
    if (found != problem.jointNames.end())
    {
        return static_cast<std::size_t>(found - problem.jointNames.begin());
    }
    const std::int32_t joint = robot.tree.findJoint(name);
    const std::int32_t driver =
        joint == kNone ? kNone : robot.tree.links[static_cast<std::size_t>(joint)].joint.mimicOf;
    if (driver != kNone)
    {
        throw std::runtime_error(
            fmt::format("--effort: joint '{}' of {} follows '{}': give the effort of that one",
                        name,
                        robot.name,
                        robot.tree.links[static_cast<std::size_t>(driver)].joint.name));
    }
    throw std::runtime_error(fmt::format("--effort: '{}' is no joint of {}: it has {}",
                                         name,
                                         robot.name,
                                         joined(problem.jointNames, ", ")));
}
}  // namespace

Effort parseEffort(const std::string& text)
{
    const std::size_t sign = text.rfind('=');
    Effort effort;
    effort.joint = sign == std::string::npos ? std::string() : text.substr(0, sign);
    const std::string number = sign == std::string::npos ? text : text.substr(sign + 1);
    if (!CLI::detail::lexical_cast(number, effort.limit) || !(effort.limit >= 0.0) || sign == 0)
    {
        throw std::invalid_argument(text +
                                    " is not an effort: give a number from 0, or JOINT=NUMBER");
    }
    effort.limit = effort.limit > 0.0 ? effort.limit : std::numeric_limits<double>::infinity();
    return effort;
}

Effort parseOwnEffort(const std::string& text)
{
    try
    {
        const Effort effort = parseEffort(text);
        if (std::isfinite(effort.limit))
        {
            return effort;
        }
    }
    catch (const std::invalid_argument&)
    {
        // What is no effort at all is none to squeeze with, either.
    }
    throw std::invalid_argument(
        text + " is no effort to squeeze with: give a number above 0, or JOINT=NUMBER");
}

void applyEfforts(const std::vector<std::string>& texts,
                  const RobotModel& robot,
                  grasp::ForceProblem& problem)
{
    for (const std::string& text : texts)
    {
        const Effort effort = parseEffort(text);
        if (effort.joint.empty())
        {
            problem.torqueLimits.assign(problem.torqueLimits.size(), effort.limit);
        }
        else
        {
            problem.torqueLimits[findJoint(effort.joint, robot, problem)] = effort.limit;
        }
    }
}
}  // namespace bullet_ccd::tools
