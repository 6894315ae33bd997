#include "tools/grasp_cli/options/planner_options.h"

#include "tools/grasp_cli/inputs/path_file.h"
#include "tools/support/option_values.h"

#include <cstdint>
#include <fmt/format.h>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
/// Plain conversion to an unsigned number would wrap negative ones around.
CLI::Validator wholeNumber()
{
    return {[](const std::string& text)
            {
                std::uint64_t value = 0;
                const bool fits =
                    text.find('-') == std::string::npos && CLI::detail::lexical_cast(text, value);
                return fits ? std::string() : fmt::format("{} is not a whole number from 0", text);
            },
            ""};
}
/// An option with a default that the help shows.
template <typename T>
CLI::Option* addValue(
    CLI::App& command, const char* names, T& value, const char* type, const char* text)
{
    return command.add_option(names, value, text)->type_name(type)->capture_default_str();
}

void setUp(grasp::ApproachOptions& options, const std::vector<double>& up)
{
    options.up = Eigen::Vector3d(up[0], up[1], up[2]);
    if (options.up.norm() < 1e-9)
    {
        throw CLI::ValidationError("--up", "a direction must not be zero");
    }
}

void setRoll(grasp::ApproachOptions& options, const std::vector<double>& limits)
{
    options.roll = grasp::RollLimits{.from = limits[0], .to = limits[1]};
    if (limits[0] > limits[1])
    {
        throw CLI::ValidationError(
            "--roll",
            fmt::format("{} is above {}: give the smaller angle first", limits[0], limits[1]));
    }
}

void addDistances(CLI::App& command, grasp::ApproachOptions& options)
{
    command
        .add_option(
            "--standoff", options.standoff, "added to the distance from which the hand starts [m]")
        ->type_name("M")
        ->check(within(0.0, kFar))
        ->capture_default_str()
        ->group("Approach");
    command
        .add_option("--reach",
                    options.reach,
                    "longest travel of the hand from its start to the first contact [m];\n"
                    "0: until it is past the object")
        ->type_name("M")
        ->check(within(0.0, kFar))
        ->capture_default_str()
        ->group("Approach");
}

void setFingers(grasp::ClosingOptions& closing, const std::vector<std::string>& words)
{
    closing.firstFingers.clear();
    const bool isWord = words.size() == 1;
    if (isWord && words[0] == grasp::toString(grasp::ClosingOrder::Together))
    {
        closing.order = grasp::ClosingOrder::Together;
        return;
    }
    closing.order = grasp::ClosingOrder::OneByOne;
    if (!isWord || words[0] != grasp::toString(grasp::ClosingOrder::OneByOne))
    {
        closing.firstFingers = words;
    }
}
}  // namespace

void addApproachOptions(CLI::App& command, grasp::ApproachOptions& options)
{
    using grasp::ApproachSource;
    command
        .add_option("--approach-from",
                    options.source,
                    "where hands come from: sphere, directions all around; surface, against\n"
                    "the normals of points of the surface; or boxes, at right angles to the\n"
                    "faces of the box along the object's principal axes")
        ->type_name("SOURCE")
        ->transform(wordFor<ApproachSource>({{"sphere", ApproachSource::Sphere},
                                             {"surface", ApproachSource::Surface},
                                             {"boxes", ApproachSource::Boxes}}))
        ->default_str(grasp::toString(options.source))
        ->group("Approach");
    auto* tableTop =
        command
            .add_flag("--table-top", options.tableTop, "no approach from below: --max-tilt holds")
            ->group("Approach");
    command
        .add_option(
            "--max-tilt", options.maxTilt, "largest angle of an approach from straight down [rad]")
        ->type_name("RAD")
        ->needs(tableTop)
        ->check(within(0.0, std::numbers::pi))
        ->default_str(fmt::format("{}", options.maxTilt))
        ->group("Approach");
    command
        .add_option_function<std::vector<double>>(
            "--up",
            [&options](const std::vector<double>& up) { setUp(options, up); },
            "direction of up in the object's frame: x y z")
        ->type_name("X..Z")
        ->expected(3)
        ->check(within(-kFar, kFar))
        ->default_str("[0,0,1]")
        ->group("Approach");
    addDistances(command, options);
    command
        .add_option_function<std::vector<double>>(
            "--roll",
            [&options](const std::vector<double>& limits) { setRoll(options, limits); },
            "limits of the roll about the direction of approach, from to [rad]: 0 where the\n"
            "fingers' opposition lies level; from above or below, along the object's x;\n"
            "default: as it fits the object")
        ->type_name("FROM..TO")
        ->expected(2)
        ->check(within(-2.0 * std::numbers::pi, 2.0 * std::numbers::pi))
        ->group("Approach");
}

void addFingersOption(CLI::App& command, grasp::ClosingOptions& closing)
{
    command
        .add_option_function<std::vector<std::string>>(
            "--fingers",
            [&closing](const std::vector<std::string>& words) { setFingers(closing, words); },
            "together; or one-by-one: the next begins when the one before it\n"
            "has stopped; or names: these first, one by one, then the others")
        ->type_name("ORDER")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->default_str(grasp::toString(closing.order))
        ->group("Closing");
}

void addEngineOption(CLI::App& command, grasp::PlannerOptions& options)
{
    command
        .add_option("--engine",
                    options.engine,
                    "how fingers close: kinematic, by time-of-impact queries alone,\n"
                    "or simulated, in Bullet's multibody world")
        ->type_name("ENGINE")
        ->transform(wordFor<grasp::ClosingEngine>({{"kinematic", grasp::ClosingEngine::Kinematic},
                                                   {"simulated", grasp::ClosingEngine::Simulated}}))
        ->default_str(grasp::toString(options.engine))
        ->group("Closing");
}

void addQualityOptions(CLI::App& command, grasp::PlannerOptions& options)
{
    addValue(command, "--friction", options.friction, "MU", "Coulomb coefficient of all contacts")
        ->check(within(1e-3, 10.0))
        ->group("Quality");
    addValue(command, "--cone-edges", options.coneEdges, "N", "edges of the friction pyramids")
        ->check(within(3, 64))
        ->group("Quality");
    addValue(command,
             "--min-epsilon",
             options.forceClosureThreshold,
             "EPS",
             "epsilon from which a grasp counts as force closure")
        ->check(within(0.0, 1.0))
        ->group("Quality");
}

void addPlannerOptions(CLI::App& command, grasp::PlannerOptions& options)
{
    addValue(command, "-n,--candidates", options.candidates, "N", "approaches to try")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000}))
        ->group("Search");
    addValue(command, "--seed", options.seed, "N", "of the sampling sequence")
        ->check(wholeNumber())
        ->group("Search");
    addValue(command,
             "-j,--jobs",
             options.jobs,
             "N",
             "threads, 0 for one a core; the result does not depend on it")
        ->check(within(0, 1024))
        ->group("Search");
    addApproachOptions(command, options.approach);
    addEngineOption(command, options);
    addQualityOptions(command, options);
    addValue(command,
             "--volumes",
             options.volumes,
             "N",
             "so many of the best grasps get the volume of their wrench space,\n"
             "which takes far longer than epsilon")
        ->check(within(0, 1'000'000))
        ->group("Quality");
}
}  // namespace bullet_ccd::tools
