#include "grasp/force/grasp_forces.h"
#include "tools/grasp_cli/answers/force_report.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/contact_options.h"
#include "tools/grasp_cli/options/effort_option.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_table.h"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

namespace bullet_ccd::tools
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]

struct ForceArguments
{
    RecordArguments records;
    RecordChoice choice;
    ContactArguments contacts;
    std::optional<double> mass;  ///< else that of the plan
    std::vector<double> gravity = {0.0, 0.0, -1.0};
    std::vector<double> wrench = std::vector<double>(6, 0.0);
    double anyWrench = 0.0;
    grasp::ForceObjective objective = grasp::ForceObjective::Total;
    grasp::ForceSolver solver = grasp::ForceSolver::Cone;
    int coneEdges = 16;
    std::vector<std::string> efforts;
    double maxForce = std::numeric_limits<double>::infinity();
    double timeLimit = 0.0;
    bool json = false;
};

/// Weight and wrench about the centre of mass.
grasp::Wrench loadOf(const ForceArguments& arguments, double mass)
{
    grasp::Wrench load = Eigen::Map<const grasp::Wrench>(arguments.wrench.data());
    const Eigen::Vector3d down = Eigen::Map<const Eigen::Vector3d>(arguments.gravity.data());
    load.head<3>() += mass * kStandardGravity * down.normalized();
    return load;
}

/// What all grasps of a run have in common.
grasp::ForceProblem commonProblem(const ForceArguments& arguments,
                                  const GraspRecords& records,
                                  double mass)
{
    const KinematicTree& tree = records.hand.hand.robot.tree;
    grasp::ForceProblem problem;
    problem.law = contactLaw(arguments.contacts, records.source.run.options);
    problem.load = loadOf(arguments, mass);
    problem.reference = records.object.object.centerOfMass;
    problem.maxNormalForce = arguments.maxForce;
    problem.torqueLimits = grasp::effortLimits(tree);
    for (const std::int32_t joint : grasp::independentJoints(tree))
    {
        problem.jointNames.push_back(tree.links[static_cast<std::size_t>(joint)].joint.name);
    }
    applyEfforts(arguments.efforts, records.hand.hand.robot, problem);
    return problem;
}

ForceRecord solveRecord(const ForceArguments& arguments,
                        const GraspRecords& records,
                        const grasp::ForceProblem& common,
                        std::size_t index)
{
    const grasp::Grasp& grasp = records.grasps[index];
    ForceRecord record{.rank = records.ranks[index],
                       .candidate = grasp.candidate,
                       .problem = common,
                       .options = {.objective = arguments.objective,
                                   .solver = arguments.solver,
                                   .coneEdges = arguments.coneEdges}};
    record.problem.contacts = grasp.contacts;
    if (grasp.positions.empty())
    {
        throw std::runtime_error(
            fmt::format("{}: candidate {} never closed ({}): choose another one",
                        arguments.records.file,
                        grasp.candidate,
                        toString(grasp.reject)));
    }
    record.problem.jacobian = grasp::handJacobian(
        records.hand.hand.robot.tree, grasp.X_WH, grasp.positions, grasp.contacts);
    if (arguments.anyWrench > 0.0)
    {
        record.disturbance = {.size = arguments.anyWrench,
                              .torqueScale = records.object.object.radius};
        record.robust =
            grasp::solveForAnyWrench(record.problem, *record.disturbance, record.options);
        record.forces = record.robust.worst;
    }
    else
    {
        record.forces = grasp::solveGraspForces(record.problem, record.options);
    }
    return record;
}

std::string unlimitedNote(const grasp::ForceProblem& problem)
{
    std::vector<std::string> names;
    for (std::size_t j = 0; j < problem.torqueLimits.size(); ++j)
    {
        if (std::isinf(problem.torqueLimits[j]))
        {
            names.push_back(problem.jointNames[j]);
        }
    }
    return names.empty() ? std::string()
                         : fmt::format(
                               "effort 0 or missing, taken as unlimited (--effort sets it): "
                               "{}\n",
                               joined(names, ", "));
}

int force(const ForceArguments& arguments)
{
    if (Eigen::Map<const Eigen::Vector3d>(arguments.gravity.data()).isZero(0.0))
    {
        throw CLI::ValidationError("--gravity", "0 0 0 has no direction: use --mass 0 for none");
    }
    const GraspRecords records = loadGraspRecords(arguments.records);
    const grasp::ObjectMass mass = massOf(records, arguments.mass);
    const grasp::ForceProblem common = commonProblem(arguments, records, mass.mass);
    const std::vector<std::size_t> chosen =
        chosenGrasps(records, arguments.records, arguments.choice);
    fmt::print(stderr, "the object's mass is {}\n{}", massText(mass), unlimitedNote(common));
    const StopRequest stop(arguments.timeLimit);
    std::size_t done = 0;
    int balanced = 0;
    for (; done < chosen.size() && !stop.isDue(); ++done)
    {
        const ForceRecord record = solveRecord(arguments, records, common, chosen[done]);
        balanced += record.status() == grasp::ForceStatus::Balanced ? 1 : 0;
        fmt::print("{}",
                   arguments.json ? forceJson(record, records.hand.hand)
                                  : forceText(record, records.hand.hand) + "\n");
    }
    if (!arguments.json)
    {
        fmt::print("{} of {} grasps balance the load\n", balanced, done);
    }
    return stop.finish("grasp force",
                       done,
                       chosen.size(),
                       "grasps",
                       records.exitCode(balanced > 0 ? kDone : kNothingFound));
}

void addLoadOptions(CLI::App& command, ForceArguments& arguments)
{
    addMassOption(
        command, arguments.mass, 0.0, "The mass of the object [kg]. Default: that of the plan.")
        ->group("Load");
    command
        .add_option(
            "--gravity", arguments.gravity, "The direction of gravity in the frame of the object.")
        ->type_name("X Y Z")
        ->expected(3)
        ->check(within(-1e6, 1e6))
        ->capture_default_str()
        ->group("Load");
    command
        .add_option("--wrench",
                    arguments.wrench,
                    "A force [N] and a moment [N m] that act on the object besides its weight, in "
                    "its frame, "
                    "about its centre of mass.")
        ->type_name("FX FY FZ TX TY TZ")
        ->expected(6)
        ->check(within(-1e9, 1e9))
        ->group("Load");
    command
        .add_option("--any-wrench",
                    arguments.anyWrench,
                    "Hold any additional wrench of this size [N], too. A moment counts as a force "
                    "times the "
                    "radius of the object.")
        ->type_name("SIZE")
        ->check(within(0.0, 1e9))
        ->group("Load");
}

void addLimitOptions(CLI::App& command, ForceArguments& arguments)
{
    command
        .add_option("--effort",
                    arguments.efforts,
                    "The largest torque [N m] or force [N] of all joints, or JOINT=E of one; 0 "
                    "sets no limit. "
                    "It may be repeated; the last one counts. Default: the efforts of the URDF.")
        ->type_name("E")
        ->check(parsedBy(parseEffort))
        ->group("Limits");
    command
        .add_option("--max-force",
                    arguments.maxForce,
                    "The largest normal force of a contact [N]. Default: unlimited.")
        ->type_name("N")
        ->check(within(1e-9, 1e9))
        ->group("Limits");
}

void addSolverOptions(CLI::App& command, ForceArguments& arguments)
{
    using grasp::ForceObjective;
    using grasp::ForceSolver;
    command
        .add_option(
            "--objective",
            arguments.objective,
            "What to look for. total: the least sum of normal forces. max: the least largest one. "
            "firm: the largest margin to slip within the limits.")
        ->type_name("WHAT")
        ->transform(wordFor<ForceObjective>({{"total", ForceObjective::Total},
                                             {"max", ForceObjective::Max},
                                             {"firm", ForceObjective::Firm}}))
        ->default_str("total")
        ->group("Method");
    command
        .add_option(
            "--solver",
            arguments.solver,
            "How to look for it. cone: with exact friction cones. lp: with inscribed pyramids.")
        ->type_name("WHICH")
        ->transform(
            wordFor<ForceSolver>({{"cone", ForceSolver::Cone}, {"lp", ForceSolver::LinearProgram}}))
        ->default_str("cone")
        ->group("Method");
    command
        .add_option("--cone-edges",
                    arguments.coneEdges,
                    "With --solver lp: the number of edges of the pyramids.")
        ->type_name("N")
        ->check(within(3, 64))
        ->capture_default_str()
        ->group("Method");
}
}  // namespace

void addForceCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "force", "Finds the smallest contact forces that hold the object in planned grasps.");
    command->footer(
        "Balances weight and wrench by contact forces within the friction cones and joint torques "
        "within the efforts, for every chosen grasp. Of a grasp that cannot, it says the reason: "
        "friction alone, or the joints.\n"
        "\n"
        "Exit codes: 0 if a chosen grasp can hold the load, 1 if none can, 130 after Ctrl-C, 2 for "
        "wrong options, 3 "
        "for "
        "bad input.\n"
        "\n"
        "Example:\n"
        "  grasp force out/grasps.jsonl --rank 1 --mass 0.4 --effort 5 --objective firm");
    const auto arguments = std::make_shared<ForceArguments>();
    addRecordOptions(*command, arguments->records);
    addChoiceOptions(*command, arguments->choice);
    addLoadOptions(*command, *arguments);
    addContactOptions(*command, arguments->contacts);
    addLimitOptions(*command, *arguments);
    addSolverOptions(*command, *arguments);
    command->add_flag(
        "--json", arguments->json, "Print one JSON record per grasp instead of tables.");
    addTimeLimitOption(*command, arguments->timeLimit, "Take no further grasp");
    command->callback([arguments, &exitCode] { exitCode = force(*arguments); });
}
}  // namespace bullet_ccd::tools
