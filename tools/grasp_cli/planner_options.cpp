#include "tools/grasp_cli/commands.h"

#include <cstdint>
#include <string>

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
}  // namespace

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
