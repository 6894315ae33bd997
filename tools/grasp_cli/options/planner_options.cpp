#include "tools/grasp_cli/options/planner_options.h"

#include "tools/grasp_cli/inputs/path_file.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/support/obstacles/obstacle_scene.h"
#include "tools/support/option_values.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
/// Of --accuracy [m]: a billionth of a hand and an object of a metre is lost in rounding.
constexpr double kSmallestAccuracy = 1e-9;
constexpr double kLargestAccuracy = 0.05;

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
        .add_option("--standoff",
                    options.standoff,
                    "How much farther away than it must the hand starts [m].")
        ->type_name("M")
        ->check(within(0.0, kFar))
        ->capture_default_str()
        ->group("Approach");
    command
        .add_option(
            "--reach",
            options.reach,
            "The longest travel of the hand from its start to its first contact [m]; 0 goes on "
            "until it is past the object.")
        ->type_name("M")
        ->check(within(0.0, kFar))
        ->capture_default_str()
        ->group("Approach");
}

void setSpeeds(grasp::ClosingOptions& closing, const std::vector<std::string>& words)
{
    closing.speeds.clear();
    for (const std::string& word : words)
    {
        const std::size_t sign = word.rfind('=');
        double ratio = 0.0;
        if (sign == std::string::npos || !CLI::detail::lexical_cast(word.substr(sign + 1), ratio) ||
            !(ratio > 0.0) || !std::isfinite(ratio))
        {
            throw CLI::ValidationError(
                "--closing-speeds",
                fmt::format("\"{}\" is no JOINT=RATIO with a ratio > 0, such as tip=0.5", word));
        }
        closing.speeds.emplace_back(word.substr(0, sign), ratio);
    }
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
        .add_option(
            "--approach-from",
            options.source,
            "Where the hand comes from. sphere: directions all around. surface: against the "
            "normals "
            "of points of the surface. boxes: at right angles to the faces of the box along the "
            "principal axes of the object. pinch: across what is thin, such as rims and handles. "
            "mixed: all of these, a quarter of them pinches; candidates are spent where they "
            "succeed.")
        ->type_name("SOURCE")
        ->transform(wordFor<ApproachSource>({{"sphere", ApproachSource::Sphere},
                                             {"surface", ApproachSource::Surface},
                                             {"boxes", ApproachSource::Boxes},
                                             {"pinch", ApproachSource::Pinch},
                                             {"mixed", ApproachSource::Mixed}}))
        ->default_str(grasp::toString(options.source))
        ->group("Approach");
    auto* tableTop =
        command
            .add_flag("--table-top",
                      options.tableTop,
                      "Approach from above only, within --max-tilt; for grasp plan a table "
                      "under the object is an obstacle.")
            ->group("Approach");
    command
        .add_option("--max-tilt",
                    options.maxTilt,
                    "The largest angle between an approach and straight down [rad].")
        ->type_name("RAD")
        ->needs(tableTop)
        ->check(within(0.0, std::numbers::pi))
        ->default_str(fmt::format("{}", options.maxTilt))
        ->group("Approach");
    command
        .add_option_function<std::vector<double>>(
            "--up",
            [&options](const std::vector<double>& up) { setUp(options, up); },
            "The direction of up in the frame of the object.")
        ->type_name("X Y Z")
        ->expected(3)
        ->check(within(-kFar, kFar))
        ->default_str("[0,0,1]")
        ->group("Approach");
    addDistances(command, options);
    command
        .add_option_function<std::vector<double>>(
            "--roll",
            [&options](const std::vector<double>& limits) { setRoll(options, limits); },
            "The limits of the roll about the direction of approach [rad]. At 0 the fingers oppose "
            "each "
            "other level, or, from above or below, along x of the object. Default: as it fits the "
            "object.")
        ->type_name("FROM TO")
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
            "Which finger closes when. together: all at once. one-by-one: the next one begins when "
            "the "
            "one before it has stopped. NAME,NAME: these first, one by one, then the others.")
        ->type_name("ORDER")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->default_str(grasp::toString(closing.order))
        ->group("Closing");
    command
        .add_option_function<double>(
            "--accuracy",
            [&closing](double accuracy) { setAccuracy(closing, accuracy); },
            "How large the gap at which links stop may be [m]. Above the default nothing is looked "
            "at more closely than that asks for; contacts are then features within 1.25 times as "
            "much.")
        ->type_name("M")
        ->check(within(kSmallestAccuracy, kLargestAccuracy))
        ->default_str(fmt::format("{:g}", closing.tolerance))
        ->group("Closing");
    command
        .add_option_function<std::vector<std::string>>(
            "--closing-speeds",
            [&closing](const std::vector<std::string>& words) { setSpeeds(closing, words); },
            "How fast joints close, as ratios to 1 rad/s or 0.1 m/s. Default: what the SRDF says, "
            "else 1.")
        ->type_name("JOINT=RATIO,...")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->group("Closing");
}

void addEngineOption(CLI::App& command, grasp::PlannerOptions& options)
{
    command
        .add_option("--engine",
                    options.engine,
                    "How fingers close. kinematic: by time-of-impact queries alone. simulated: as "
                    "a multibody "
                    "in a world of Bullet.")
        ->type_name("ENGINE")
        ->transform(wordFor<grasp::ClosingEngine>({{"kinematic", grasp::ClosingEngine::Kinematic},
                                                   {"simulated", grasp::ClosingEngine::Simulated}}))
        ->default_str(grasp::toString(options.engine))
        ->group("Closing");
}

void addQualityOptions(CLI::App& command, grasp::PlannerOptions& options)
{
    addValue(command,
             "--friction",
             options.friction,
             "MU",
             "Coulomb's coefficient of friction of all contacts.")
        ->check(within(1e-3, 10.0))
        ->group("Quality");
    addValue(command,
             "--cone-edges",
             options.coneEdges,
             "N",
             "How epsilon takes friction: 0 by exact cones, else by pyramids with so many edges, "
             "which depend on the frame of the object.")
        ->check(within(0, 0) | within(3, 64))
        ->group("Quality");
    addValue(command,
             "--min-epsilon",
             options.forceClosureThreshold,
             "EPS",
             "The epsilon from which on a grasp counts as force closure.")
        ->check(within(0.0, 1.0))
        ->group("Quality");
    addMassOption(command,
                  options.mass,
                  1e-9,
                  fmt::format("The mass of the object [kg], for the question whether a grasp holds "
                              "its weight in any direction within the efforts of the joints. {}",
                              kMassDefault))
        ->group("Quality");
}

void addPlannerOptions(CLI::App& command, grasp::PlannerOptions& options)
{
    addValue(command, "-n,--candidates", options.candidates, "N", "How many approaches to try.")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000}))
        ->group("Search");
    addValue(command,
             "--seed",
             options.seed,
             "N",
             "Where the sequence of samples starts. The same seed gives the same grasps.")
        ->check(wholeNumber())
        ->group("Search");
    addValue(command,
             "-j,--jobs",
             options.jobs,
             "N",
             "The number of threads; 0 takes one per core. The result does not depend on it.")
        ->check(within(0, 1024))
        ->group("Search");
    addApproachOptions(command, options.approach);
    addEngineOption(command, options);
    addQualityOptions(command, options);
    addValue(
        command,
        "--volumes",
        options.volumes,
        "N",
        "How many of the best grasps get the volume of their wrench space, which takes far longer "
        "than epsilon.")
        ->check(within(0, 1'000'000))
        ->group("Quality");
}

void setAccuracy(grasp::ClosingOptions& closing, double accuracy)
{
    closing.tolerance = accuracy;
    closing.contactThreshold = std::max(closing.contactThreshold, 1.25 * accuracy);
}

void setAccuracyOfScenes(grasp::ClosingOptions& closing, std::span<const std::string> scenes)
{
    std::optional<double> stated;
    if (closing.tolerance != kDefaultTolerance)
    {
        stated = closing.tolerance;
    }
    if (const std::optional<double> accuracy = accuracyOf(scenes, stated))
    {
        if (!(*accuracy >= kSmallestAccuracy && *accuracy <= kLargestAccuracy))
        {
            throw std::runtime_error(fmt::format("accuracy: {} of the scene is not from {} to {} m",
                                                 *accuracy,
                                                 kSmallestAccuracy,
                                                 kLargestAccuracy));
        }
        setAccuracy(closing, *accuracy);
    }
}
}  // namespace bullet_ccd::tools
