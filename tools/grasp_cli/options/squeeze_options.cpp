#include "tools/grasp_cli/options/squeeze_options.h"

#include "grasp/force/grasp_forces.h"
#include "tools/grasp_cli/options/effort_option.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/support/option_values.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>

namespace bullet_ccd::tools
{
void addSqueezeOptions(CLI::App& command, SqueezeArguments& arguments)
{
    command
        .add_option(
            "--firmness",
            arguments.firmness,
            "Half of it times its weight may pull in any direction before a contact slips, "
            "and the normal forces add up to it times weight / friction at least, where the "
            "efforts allow it.")
        ->type_name("F")
        ->check(within(1.2, 1e3))
        ->capture_default_str()
        ->group("Squeeze");
    command
        .add_option(
            "--effort",
            arguments.efforts,
            "The largest torque [N m] or force [N] of all joints, or JOINT=E of one. It "
            "may be repeated; the last one counts. Default: the efforts of the URDF; where "
            "it says none, 0, or more than 8 N m or 500 N of a finger: 1 N m or 40 N. A motor "
            "that moves several joints gives what all of them may bear.")
        ->type_name("E")
        ->check(parsedBy(parseOwnEffort))
        ->group("Squeeze");
}

void addRecordSqueezeOptions(CLI::App& command,
                             std::optional<double>& mass,
                             std::optional<double>& friction,
                             SqueezeArguments& arguments)
{
    addMassOption(command, mass, 1e-6, "The mass of the object [kg]. Default: that of the plan.")
        ->group("Squeeze");
    command
        .add_option("--friction",
                    friction,
                    "Coulomb's coefficient of all contacts. Default: that of the plan.")
        ->type_name("MU")
        ->check(within(1e-6, 10.0))
        ->group("Squeeze");
    addSqueezeOptions(command, arguments);
}

std::vector<std::string> independentJointNames(const KinematicTree& tree)
{
    std::vector<std::string> names;
    for (const std::int32_t joint : grasp::independentJoints(tree))
    {
        names.push_back(tree.links[static_cast<std::size_t>(joint)].joint.name);
    }
    return names;
}

grasp::SqueezeOptions squeezeOptionsOf(const SqueezeArguments& arguments,
                                       double friction,
                                       const grasp::HandModel& hand)
{
    grasp::SqueezeOptions options{
        .mass = arguments.mass, .friction = friction, .firmness = arguments.firmness};
    if (!arguments.efforts.empty())
    {
        grasp::ForceProblem problem;
        problem.jointNames = independentJointNames(hand.robot.tree);
        for (const grasp::JointEffort& effort : grasp::jointEfforts(hand))
        {
            problem.torqueLimits.push_back(effort.limit);
        }
        applyEfforts(arguments.efforts, hand.robot, problem);
        options.efforts = problem.torqueLimits;
    }
    return options;
}

std::string assumedEfforts(const grasp::SqueezeOptions& options, const grasp::HandModel& hand)
{
    if (!options.efforts.empty())
    {
        return {};
    }
    const std::vector<std::string> names = independentJointNames(hand.robot.tree);
    const std::vector<grasp::JointEffort> efforts = grasp::jointEfforts(hand);
    const double first = efforts.empty() ? 0.0 : efforts.front().limit;
    if (!efforts.empty() &&
        std::ranges::all_of(
            efforts, [&](const grasp::JointEffort& e) { return e.isAssumed && e.limit == first; }))
    {
        return fmt::format("{} for all joints", first);
    }
    std::vector<std::string> assumed;
    for (std::size_t j = 0; j < names.size(); ++j)
    {
        if (efforts[j].isAssumed)
        {
            assumed.push_back(fmt::format("{}={}", names[j], efforts[j].limit));
        }
    }
    return joined(assumed, ", ");
}
}  // namespace bullet_ccd::tools
