#include "grasp/force/grasp_forces.h"
#include "grasp/trial/grasp_trial.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/effort_option.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

namespace bullet_ccd::tools
{
namespace
{
using grasp::TrialOutcome;
using grasp::TrialProtocol;
using grasp::TrialResult;

struct TrialArguments
{
    RecordArguments records;
    RecordChoice choice;
    std::vector<std::string> protocols{"six"};
    double mass = grasp::SqueezeOptions{}.mass;
    std::optional<double> friction;  ///< else that of the plan
    double firmness = grasp::SqueezeOptions{}.firmness;
    std::vector<std::string> efforts;
    double rate = grasp::TrialOptions{}.rate;
    double timeLimit = 0.0;
    bool json = false;
};

std::vector<std::string> protocolNames()
{
    return {toString(TrialProtocol::Six),
            toString(TrialProtocol::Hover),
            toString(TrialProtocol::Shake)};
}

TrialProtocol protocolOf(const std::string& name)
{
    const std::vector<std::string> names = protocolNames();
    return static_cast<TrialProtocol>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::vector<std::string> jointNames(const KinematicTree& tree)
{
    std::vector<std::string> names;
    for (const std::int32_t joint : grasp::independentJoints(tree))
    {
        names.push_back(tree.links[static_cast<std::size_t>(joint)].joint.name);
    }
    return names;
}

/// Options of all trials; says which efforts are assumed.
grasp::TrialOptions trialOptions(const TrialArguments& arguments, const GraspRecords& records)
{
    const RobotModel& robot = records.hand.hand.robot;
    grasp::TrialOptions options;
    options.rate = arguments.rate;
    options.squeeze.mass = arguments.mass;
    options.squeeze.friction = arguments.friction.value_or(records.source.run.options.friction);
    options.squeeze.firmness = arguments.firmness;
    grasp::ForceProblem problem;
    problem.jointNames = jointNames(robot.tree);
    std::vector<std::string> assumed;
    for (const grasp::JointEffort& effort : grasp::jointEfforts(robot.tree))
    {
        if (effort.isAssumed)
        {
            assumed.push_back(fmt::format(
                "{}={}", problem.jointNames[problem.torqueLimits.size()], effort.limit));
        }
        problem.torqueLimits.push_back(effort.limit);
    }
    if (!arguments.efforts.empty())
    {
        applyEfforts(arguments.efforts, robot, problem);
        options.squeeze.efforts = problem.torqueLimits;
    }
    else if (!assumed.empty())
    {
        fmt::print(stderr,
                   "effort missing, 0 or more than a finger has, so assumed (--effort sets it): "
                   "{}\n",
                   joined(assumed, ", "));
    }
    return options;
}

std::string trialJson(std::size_t rank,
                      const grasp::Grasp& grasp,
                      TrialProtocol protocol,
                      const TrialResult& result,
                      const std::vector<std::string>& joints)
{
    nlohmann::ordered_json torques = nlohmann::ordered_json::object();
    for (std::size_t j = 0; j < result.peakTorques.size(); ++j)
    {
        torques[joints[j]] = result.peakTorques[j];
    }
    const bool isLost =
        result.outcome == TrialOutcome::Dropped || result.outcome == TrialOutcome::Ejected;
    const nlohmann::ordered_json json{
        {"schema", "bullet_ccd.trial/1"},
        {"rank", rank},
        {"candidate", grasp.candidate},
        {"protocol", toString(protocol)},
        {"outcome", toString(result.outcome)},
        {"reason",
         result.reason.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(result.reason)},
        {"slip_m", result.slip},
        {"turn_rad", result.turn},
        {"lost_at_s", isLost ? nlohmann::ordered_json(result.lostAt) : nlohmann::ordered_json()},
        {"peak_contact_force_n", result.peakForce},
        {"mean_normal_force_n", result.meanForce},
        {"peak_energy_j", result.peakEnergy},
        {"peak_torques", std::move(torques)},
        {"intersecting_triangles", result.penetration.intersectingTriangles},
        {"penetration_m", result.penetration.deepest},
        {"simulated_s", result.seconds},
        {"inexact_solves", result.inexactSolves}};
    return json.dump() + "\n";
}

std::vector<std::string> trialRow(std::size_t rank,
                                  const grasp::Grasp& grasp,
                                  TrialProtocol protocol,
                                  const TrialResult& result)
{
    return {std::to_string(rank),
            fmt::format("{:.4f}", grasp.quality.epsilon),
            toString(protocol),
            toString(result.outcome),
            fmt::format("{:.3f}", 1e3 * result.slip),
            fmt::format("{:.3f}", result.turn * 180.0 / std::numbers::pi),
            fmt::format("{:.2f}", result.peakForce),
            fmt::format("{:.2f}", result.meanForce),
            std::to_string(result.penetration.intersectingTriangles),
            result.reason};
}

int trial(const TrialArguments& arguments)
{
    const GraspRecords records = loadGraspRecords(arguments.records);
    const grasp::TrialOptions options = trialOptions(arguments, records);
    const std::vector<std::size_t> chosen =
        chosenGrasps(records, arguments.records, arguments.choice);
    const std::vector<std::string> joints = jointNames(records.hand.hand.robot.tree);
    TextTable table{.header = {"rank",
                               "epsilon",
                               "protocol",
                               "outcome",
                               "slip mm",
                               "turn deg",
                               "peak N",
                               "mean N",
                               "intersections",
                               "why"},
                    .rows = {}};
    std::map<std::string, int> counts;
    const StopRequest stop(arguments.timeLimit);
    std::size_t done = 0;
    for (; done < chosen.size() && !stop.isDue(); ++done)
    {
        const grasp::Grasp& grasp = records.grasps[chosen[done]];
        const std::size_t rank = chosen[done] + 1;
        for (const std::string& name : arguments.protocols)
        {
            const TrialProtocol protocol = protocolOf(name);
            const TrialResult result =
                grasp::runTrial(records.hand.hand, records.object.object, grasp, protocol, options);
            ++counts[toString(result.outcome)];
            if (arguments.json)
            {
                fmt::print("{}", trialJson(rank, grasp, protocol, result, joints));
            }
            else
            {
                table.rows.push_back(trialRow(rank, grasp, protocol, result));
            }
        }
    }
    const int held = counts[toString(TrialOutcome::Held)];
    if (!arguments.json)
    {
        fmt::print("{}", alignedText(table));
        for (const auto& [outcome, count] : counts)
        {
            if (count > 0)
            {
                fmt::print("{}: {} of {}\n", outcome, count, done * arguments.protocols.size());
            }
        }
    }
    return stop.finish(
        "grasp trial", done, chosen.size(), "grasps", held > 0 ? kDone : kNothingFound);
}
}  // namespace

void addTrialCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "trial", "Tries in a simulation whether planned grasps hold the object.");
    command->footer(
        "The hand squeezes by what its efforts allow, with the object free, and the protocol loads "
        "it. six: its weight along +-x, +-y, +-z of its frame, 1 s each. hover: its weight along "
        "-z, 10 s. shake: its weight along -z, and the hand moved by 20 mm at 2 Hz along x, y and "
        "z, 2 s each. Held means that the object moved by at most 10 mm and 15 degrees; dropped, "
        "by more than 100 mm.\n"
        "\n"
        "Exit codes: 0 if a trial held, 1 if none did, 130 after Ctrl-C, 2 for wrong options, 3 "
        "for bad input.\n"
        "\n"
        "Example:\n"
        "  grasp trial out/grasps.jsonl --protocol six --protocol shake --mass 0.25");
    const auto arguments = std::make_shared<TrialArguments>();
    addRecordOptions(*command, arguments->records);
    addChoiceOptions(*command, arguments->choice);
    command
        ->add_option("--protocol",
                     arguments->protocols,
                     "What is done to the object: six, hover or shake. It may be repeated.")
        ->type_name("NAME")
        ->check(CLI::IsMember(protocolNames()))
        ->capture_default_str()
        ->group("Load");
    command->add_option("--mass", arguments->mass, "The mass of the object [kg].")
        ->type_name("KG")
        ->check(within(1e-6, 1e3))
        ->capture_default_str()
        ->group("Load");
    command
        ->add_option("--friction",
                     arguments->friction,
                     "Coulomb's coefficient of all contacts. Default: that of the plan.")
        ->type_name("MU")
        ->check(within(1e-6, 10.0))
        ->group("Load");
    command
        ->add_option("--firmness",
                     arguments->firmness,
                     "What the normal forces add up to, over weight / friction, where the efforts "
                     "allow it.")
        ->type_name("F")
        ->check(within(1.2, 1e3))
        ->capture_default_str()
        ->group("Hand");
    command
        ->add_option("--effort",
                     arguments->efforts,
                     "The largest torque [N m] or force [N] of all joints, or JOINT=E of one. It "
                     "may be repeated; the last one counts. Default: the efforts of the URDF, and "
                     "1 N m or 40 N where it says none, 0, or more than 20 N m or 500 N.")
        ->type_name("E")
        ->check(parsedBy(parseEffort))
        ->group("Hand");
    command->add_option("--rate", arguments->rate, "Steps of the simulation per second.")
        ->type_name("HZ")
        ->check(within(60.0, 1e4))
        ->capture_default_str()
        ->group("Method");
    command->add_flag(
        "--json", arguments->json, "Print one JSON record per trial instead of a table.");
    addTimeLimitOption(*command, arguments->timeLimit, "Try no further grasp");
    command->callback([arguments, &exitCode] { exitCode = trial(*arguments); });
}
}  // namespace bullet_ccd::tools
