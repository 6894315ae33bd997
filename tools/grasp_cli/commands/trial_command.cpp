#include "bullet_ccd/math/replace_file.h"
#include "grasp/trial/grasp_trial.h"
#include "tools/grasp_cli/answers/trial_films.h"
#include "tools/grasp_cli/answers/trial_models.h"
#include "tools/grasp_cli/answers/trial_runs.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/grasp_cli/options/squeeze_options.h"
#include "tools/support/option_values.h"
#include "tools/support/progress_line.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <system_error>

namespace bullet_ccd::tools
{
namespace
{
using grasp::TrialOutcome;
using grasp::TrialProtocol;
using grasp::TrialPull;
using grasp::TrialResult;

/// Of --skin [m].
constexpr double kSmallestSkin = 1e-4;
constexpr double kLargestSkin = 1e-2;
/// Of --accuracy [m].
constexpr double kSmallestAccuracy = 1e-5;
constexpr double kLargestAccuracy = 2e-2;

struct TrialArguments
{
    RecordArguments records;
    RecordChoice choice;
    std::vector<std::string> protocols{"six"};
    SqueezeArguments squeeze;
    std::optional<double> mass;      ///< else that of the plan
    std::optional<double> friction;  ///< same
    std::optional<double> surfaceFriction;
    int pulls = 0;
    double rate = grasp::TrialOptions{}.rate;
    bool brief = false;
    double skin = grasp::TrialOptions{}.skin;
    double accuracy = 0.0;  ///< 0: full models
    double skinStiffness = grasp::TrialOptions{}.skinStiffness;
    std::uint64_t seed = grasp::TrialOptions{}.seed;
    int jobs = 0;
    double timeLimit = 0.0;
    bool json = false;
    std::filesystem::path films;  ///< a folder
};

/// Options of all trials; says which efforts are assumed.
grasp::TrialOptions trialOptions(const TrialArguments& arguments, const GraspRecords& records)
{
    const grasp::HandModel& hand = records.hand.hand;
    const grasp::PlannerOptions& plan = records.source.run.options;
    grasp::TrialOptions options;
    SqueezeArguments squeeze = arguments.squeeze;
    const grasp::ObjectMass mass = massOf(records, arguments.mass);
    squeeze.mass = mass.mass;
    options.squeeze = squeezeOptionsOf(squeeze, arguments.friction.value_or(plan.friction), hand);
    options.friction = arguments.surfaceFriction;
    options.rate = arguments.rate;
    options.brief = arguments.brief;
    options.up = plan.approach.up;
    options.seed = arguments.seed;
    options.skin = arguments.skin;
    options.skinStiffness = arguments.skinStiffness;
    fmt::print(stderr, "the object's mass is {}\n", massText(mass));
    if (const std::string assumed = assumedEfforts(options.squeeze, hand); !assumed.empty())
    {
        fmt::print(stderr,
                   "effort missing, 0 or more than a finger has, so assumed (--effort sets it): "
                   "{}\n",
                   assumed);
    }
    return options;
}

std::string trialJson(const GraspRecords& records,
                      std::size_t index,
                      const grasp::TrialOptions& options,
                      const TrialProtocol& protocol,
                      const TrialResult& result,
                      const std::vector<std::string>& joints)
{
    const grasp::Grasp& grasp = records.grasps[index];
    const auto byJoint = [&](const std::vector<double>& torques)
    {
        nlohmann::ordered_json json = nlohmann::ordered_json::object();
        for (std::size_t j = 0; j < torques.size(); ++j)
        {
            json[joints[j]] = torques[j];
        }
        return json;
    };
    const bool isLost =
        result.outcome == TrialOutcome::Dropped || result.outcome == TrialOutcome::Ejected;
    nlohmann::ordered_json pulls = nlohmann::ordered_json::array();
    for (const TrialPull& pull : result.pulls)
    {
        pulls.push_back({{"force", std::vector<double>(pull.wrench.data(), pull.wrench.data() + 3)},
                         {"moment_over_radius",
                          std::vector<double>(pull.wrench.data() + 3, pull.wrench.data() + 6)},
                         {"size_n", pull.size},
                         {"share", pull.share},
                         {"slipped", pull.slipped}});
    }
    const nlohmann::ordered_json json{
        {"schema", "bullet_ccd.trial/1"},
        {"hand", records.hand.hand.robot.name},
        {"object", records.object.object.name},
        {"rank", records.ranks[index]},
        {"candidate", grasp.candidate},
        {"protocol", protocol.name},
        {"mass_kg", *options.squeeze.mass},
        {"friction", options.squeeze.friction},
        {"surface_friction", options.friction.value_or(options.squeeze.friction)},
        {"rate_hz", options.rate},
        {"seed", options.seed},
        {"brief", options.brief},
        {"epsilon", grasp.quality.epsilon},
        {"outcome", toString(result.outcome)},
        {"reason",
         result.reason.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(result.reason)},
        {"slip_m", result.slip},
        {"turn_rad", result.turn},
        {"lost_at_s", isLost ? nlohmann::ordered_json(result.lostAt) : nlohmann::ordered_json()},
        {"peak_contact_force_n", result.peakForce},
        {"mean_normal_force_n", result.meanForce},
        {"peak_energy_j", result.peakEnergy},
        {"peak_torques", byJoint(result.peakTorques)},
        {"mean_torques", byJoint(result.meanTorques)},
        {"pulls", std::move(pulls)},
        {"intersecting_triangles", result.penetration.intersectingTriangles},
        {"penetration_m", result.penetration.deepest},
        {"simulated_s", result.seconds},
        {"inexact_solves", result.inexactSolves}};
    return json.dump() + "\n";
}

/// What the weakest direction resisted, over the normal forces: epsilon is a bound of it.
std::string pullText(const TrialResult& result)
{
    const auto least =
        std::min_element(result.pulls.begin(),
                         result.pulls.end(),
                         [](const TrialPull& a, const TrialPull& b) { return a.share < b.share; });
    return fmt::format(
        "least pull {:.3f} of the normal forces, {:.2f} N", least->share, least->size);
}

std::vector<std::string> trialRow(int rank,
                                  const grasp::Grasp& grasp,
                                  const TrialProtocol& protocol,
                                  const TrialResult& result)
{
    return {std::to_string(rank),
            fmt::format("{:.4f}", grasp.quality.epsilon),
            protocol.name,
            toString(result.outcome),
            fmt::format("{:.3f}", 1e3 * result.slip),
            fmt::format("{:.3f}", result.turn * 180.0 / std::numbers::pi),
            fmt::format("{:.2f}", result.peakForce),
            fmt::format("{:.2f}", result.meanForce),
            std::to_string(result.penetration.intersectingTriangles),
            result.pulls.empty() ? result.reason : pullText(result)};
}

std::vector<TrialProtocol> chosenProtocols(const TrialArguments& arguments)
{
    std::vector<TrialProtocol> protocols = protocolsNamed(arguments.protocols, "--protocol");
    if (arguments.pulls > 0 && std::ranges::count(protocols, "pull", &TrialProtocol::name) == 0)
    {
        throw CLI::ValidationError(
            "--pulls",
            "changes nothing without the protocol pull: give --protocol pull, or drop it");
    }
    for (TrialProtocol& protocol : protocols)
    {
        if (arguments.pulls > 0 && protocol.name == "pull")
        {
            protocol.phases = grasp::randomPulls(arguments.pulls, arguments.seed);
        }
    }
    return protocols;
}

std::string filmName(const TrialProtocol& protocol, int rank)
{
    return fmt::format("{}_{:02}", protocol.name, rank);
}

/// Creates the folder of the films and proves that it can be written. Throws std::runtime_error.
void prepareFilms(const std::filesystem::path& folder)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    error = error ? error : tryReplaceFile(folder / "film.png");
    if (error)
    {
        throw std::runtime_error(
            fmt::format("--films {}: cannot be written ({}): give another folder",
                        folder.string(),
                        error.message()));
    }
}

/// Returns whether all could be written; the others are named on stderr.
bool writeFilms(const TrialArguments& arguments,
                const GraspRecords& records,
                const std::vector<std::size_t>& chosen,
                const std::vector<TrialProtocol>& protocols,
                const std::vector<std::vector<TrialFilm>>& films)
{
    bool isDone = true;
    for (std::size_t k = 0; !arguments.films.empty() && k < films.size(); ++k)
    {
        for (std::size_t p = 0; p < protocols.size(); ++p)
        {
            if (films[k][p].isEmpty())
            {
                continue;
            }
            std::optional<Eigen::Vector3d> up;
            if (protocols[p].start == grasp::TrialStart::Table)
            {
                up = records.source.run.options.approach.up;
            }
            try
            {
                films[k][p].write(arguments.films,
                                  filmName(protocols[p], records.ranks[chosen[k]]),
                                  records.hand.hand,
                                  records.object.object,
                                  up);
            }
            catch (const std::exception& error)
            {
                fmt::print(stderr, "left out: a film: {}\n", error.what());
                isDone = false;
            }
        }
    }
    return isDone;
}

struct TriedRows
{
    std::vector<TrialRow> rows;
    bool hasFilms = true;  ///< all that were asked for
};

/// Runs the trials with progress on stderr, and looks at the penetration of the full meshes. JSON
/// records are printed as soon as those before them are.
TriedRows tryAll(const TrialArguments& arguments,
                 const GraspRecords& records,
                 const GraspRecords& full,
                 const std::vector<std::size_t>& chosen,
                 const std::vector<TrialProtocol>& protocols,
                 const StopRequest& stop)
{
    const std::vector<std::string> joints = independentJointNames(records.hand.hand.robot.tree);
    std::vector<const grasp::Grasp*> grasps;
    for (const std::size_t index : chosen)
    {
        grasps.push_back(&records.grasps[index]);
    }
    const grasp::TrialOptions options = trialOptions(arguments, records);
    std::size_t ended = 0;
    std::size_t row = 0;
    std::size_t column = 0;
    // Of the results that are there and were not printed yet; at the end, behind gaps as well.
    const auto print = [&](const std::vector<TrialRow>& rows, bool isEnd)
    {
        for (; row < rows.size(); ++row, column = 0)
        {
            for (; column < protocols.size(); ++column)
            {
                const std::optional<TrialResult>& result = rows[row].results[column];
                if (!result && rows[row].error.empty() && !isEnd)
                {
                    return;
                }
                if (result && arguments.json)
                {
                    fmt::print(
                        "{}",
                        trialJson(
                            records, chosen[row], options, protocols[column], *result, joints));
                    std::fflush(stdout);
                }
            }
        }
    };
    std::vector<std::vector<TrialFilm>> films(grasps.size(),
                                              std::vector<TrialFilm>(protocols.size()));
    TrialWatch watch;
    if (!arguments.films.empty())
    {
        watch = [&](std::size_t k, std::size_t p)
        { return [&film = films[k][p]](const grasp::TrialFrame& frame) { film.take(frame); }; };
    }
    ProgressLine progress(
        grasps.size() * protocols.size(),
        fmt::format("trials of {} x {}", records.hand.hand.robot.name, records.object.object.name));
    std::vector<TrialRow> rows = runTrials(
        records.hand.hand,
        records.object.object,
        grasps,
        protocols,
        options,
        arguments.jobs,
        stop,
        {full.hand.hand, full.object.object},
        [&](const std::vector<TrialRow>& soFar)
        {
            print(soFar, false);
            progress.show(++ended);
        },
        watch);
    print(rows, true);
    const bool hasFilms = writeFilms(arguments, records, chosen, protocols, films);
    return {.rows = std::move(rows), .hasFilms = hasFilms};
}

int trial(const TrialArguments& arguments)
{
    const std::vector<TrialProtocol> protocols = chosenProtocols(arguments);
    GraspRecords records = loadGraspRecords(arguments.records);
    const std::vector<std::size_t> chosen =
        chosenGrasps(records, arguments.records, arguments.choice);
    if (!arguments.films.empty())
    {
        prepareFilms(arguments.films);
    }
    std::optional<GraspRecords> full;
    if (arguments.accuracy > 0.0)
    {
        full = loadGraspRecords(arguments.records);
        const TrialModels models =
            reduceForTrial(records.hand.hand, records.object.object, arguments.accuracy);
        fmt::print(arguments.json ? stderr : stdout, "{}\n", plainText(models));
    }
    const StopRequest stop(arguments.timeLimit);
    const Stopwatch watch;
    const std::clock_t began = std::clock();
    const auto [rows, hasFilms] =
        tryAll(arguments, records, full ? *full : records, chosen, protocols, stop);
    const double ofProcessor = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
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
    std::map<std::string, int> tried;
    const double seconds = watch.seconds();
    double simulated = 0.0;
    double deepest = 0.0;
    bool isHeld = false;
    bool hasFailed = !hasFilms;
    for (std::size_t k = 0; k < rows.size(); ++k)
    {
        const grasp::Grasp& grasp = records.grasps[chosen[k]];
        if (!rows[k].error.empty())
        {
            fmt::print(stderr, "left out: rank {}: {}\n", records.ranks[chosen[k]], rows[k].error);
            hasFailed = true;
        }
        for (std::size_t p = 0; p < protocols.size(); ++p)
        {
            if (const std::optional<TrialResult>& result = rows[k].results[p])
            {
                simulated += result->seconds;
                deepest = std::max(deepest, result->penetration.deepest);
                isHeld = isHeld || result->outcome == TrialOutcome::Held;
                ++tried[protocols[p].name];
                ++counts[protocols[p].name + ": " + toString(result->outcome)];
                table.rows.push_back(
                    trialRow(records.ranks[chosen[k]], grasp, protocols[p], *result));
            }
        }
    }
    if (!arguments.json)
    {
        fmt::print("{}", alignedText(table));
        for (const auto& [outcome, count] : counts)
        {
            fmt::print(
                "{}: {} of {}\n", outcome, count, tried[outcome.substr(0, outcome.rfind(": "))]);
        }
    }
    std::FILE* const out = arguments.json ? stderr : stdout;
    if (full)
    {
        fmt::print(out, "full meshes were inside each other by {:.3f} mm at most\n", 1e3 * deepest);
    }
    fmt::print(out,
               "simulated {:.1f} s in {:.1f} s, {:.2f} s of the processor, {:.3f} ms a step\n",
               simulated,
               seconds,
               ofProcessor,
               1e3 * ofProcessor / std::max(1.0, simulated * arguments.rate));
    const int exitCode =
        hasFailed ? static_cast<int>(kBadInput) : records.exitCode(isHeld ? kDone : kNothingFound);
    return stop.finish("grasp trial",
                       static_cast<std::size_t>(std::ranges::count_if(rows, &TrialRow::isDone)),
                       chosen.size(),
                       "grasps",
                       exitCode);
}
}  // namespace

void addTrialCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "trial", "Tries in a simulation whether planned grasps hold the object.");
    command->footer(
        "The hand squeezes by what its efforts allow, with the object free, and the protocol loads "
        "it.\n"
        "  six      its weight along +-x, +-y, +-z of its frame, 1 s each\n"
        "  hover    its weight along -z, 10 s\n"
        "  shake    the hand moved by 20 mm at 2 Hz along x, y and z, 2 s each\n"
        "  lift     from a table: closing with the object free, up by 0.2 m in 1 s, then\n"
        "           3 s of hold\n"
        "  pull     a force along +-x, +-y, +-z that grows until it slips; with --pulls,\n"
        "           random wrenches\n"
        "  disturb  the hand off by 5 mm and 5 degrees before it closes; then as six\n"
        "Or a protocol of your own, as a YAML file: see grasp/trial/README.md. Up is that of the "
        "plan "
        "(z by default).\n"
        "Held means that the object moved by at most 10 mm and 15 degrees; dropped, by more than "
        "100 "
        "mm.\n"
        "\n"
        "After Ctrl-C, or at the time limit, the trials that were done are printed; JSON records "
        "are printed as they come. Records that are damaged and grasps that never closed are "
        "named and left out.\n"
        "\n"
        "Exit codes: 0 if a trial held, 1 if none did, 130 after Ctrl-C, 2 for wrong options, 3 "
        "for bad input, also if something was left out.\n"
        "\n"
        "Example:\n"
        "  grasp trial out/grasps.jsonl --protocol lift,six --mass 0.25");
    const auto arguments = std::make_shared<TrialArguments>();
    addRecordOptions(*command, arguments->records);
    addChoiceOptions(*command, arguments->choice);
    command
        ->add_option("--protocol",
                     arguments->protocols,
                     "What is done to the object: six, hover, shake, lift, pull, disturb, or a "
                     "YAML file. It "
                     "may be repeated, or a list with commas.")
        ->type_name("NAME")
        ->capture_default_str()
        ->group("Load");
    addRecordSqueezeOptions(*command, arguments->mass, arguments->friction, arguments->squeeze);
    command
        ->add_option("--surface-friction",
                     arguments->surfaceFriction,
                     "The friction that the surfaces have, where it is not what the squeeze counts "
                     "on.")
        ->type_name("MU")
        ->check(within(0.0, 10.0))
        ->group("Load");
    command
        ->add_option("--pulls",
                     arguments->pulls,
                     "Protocol pull: along so many random wrenches instead of six forces.")
        ->type_name("N")
        ->check(within(1, 10000))
        ->group("Load");
    command->add_option("--seed", arguments->seed, "Of random wrenches and errors of the pose.")
        ->type_name("S")
        ->check(wholeNumber())
        ->capture_default_str()
        ->group("Load");
    command
        ->add_flag("--brief",
                   arguments->brief,
                   "Cut a phase of constant load short where the object would move by less than 1 "
                   "mm and 1 degree in the rest of it.")
        ->group("Load");
    command->add_option("--rate", arguments->rate, "Steps of the simulation per second.")
        ->type_name("HZ")
        ->check(within(60.0, 1e4))
        ->capture_default_str()
        ->group("Method");
    command
        ->add_option("--skin", arguments->skin, "The gap at which surfaces rest on each other [m].")
        ->type_name("M")
        ->check(within(kSmallestSkin, kLargestSkin))
        ->capture_default_str()
        ->group("Method");
    command
        ->add_option("--accuracy",
                     arguments->accuracy,
                     "Simulate smaller models, of which the full meshes come into each other by "
                     "less than this [m]. Default: full models.")
        ->type_name("M")
        ->check(within(kSmallestAccuracy, kLargestAccuracy))
        ->group("Method");
    command
        ->add_option("--skin-stiffness",
                     arguments->skinStiffness,
                     "How hard a contact point is against being pressed into that gap [N/m].")
        ->type_name("K")
        ->check(within(1.0, 1e9))
        ->capture_default_str()
        ->group("Method");
    command
        ->add_option(
            "-j,--jobs", arguments->jobs, "Threads; 0: one per core. Results do not depend on it.")
        ->type_name("N")
        ->check(within(0, 1024))
        ->capture_default_str()
        ->group("Method");
    command->add_flag(
        "--json", arguments->json, "Print one JSON record per trial instead of a table.");
    command
        ->add_option(
            "--films",
            arguments->films,
            "A folder for what each trial looked like: PROTOCOL_RANK.png, side by side the "
            "start, the first contact, the end of the squeeze and the end, and "
            "PROTOCOL_RANK.glb, an animation.")
        ->type_name("FOLDER")
        ->group("Output");
    addTimeLimitOption(*command, arguments->timeLimit, "Try no further grasp");
    command->callback([arguments, &exitCode] { exitCode = trial(*arguments); });
}
}  // namespace bullet_ccd::tools
