#include "tools/ccd_cli/commands/commands.h"
#include "tools/support/pose_text.h"
#include "tools/support/option_values.h"

#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::array<std::pair<const char*, ToiStrategy>, 3> kStrategies{
    {{"c2a", ToiStrategy::C2A},
     {"interval", ToiStrategy::Interval},
     {"best-first", ToiStrategy::BestFirst}}};

/// A tolerance must be above zero, a separation may be zero.
CLI::Validator distance(bool zeroAllowed)
{
    return parsedBy(
        [zeroAllowed](const std::string& text)
        {
            const double value = numberFrom(text);
            if (value < 0.0 || (value == 0.0 && !zeroAllowed))
            {
                throw std::invalid_argument(
                    fmt::format("{} is not a distance {} 0", text, zeroAllowed ? ">=" : ">"));
            }
        });
}
}  // namespace

std::string strategyName(ToiStrategy strategy)
{
    for (const auto& [name, value] : kStrategies)
    {
        if (value == strategy)
        {
            return name;
        }
    }
    throw std::invalid_argument("strategy without a name");
}

void addToiOptions(CLI::App& command, ToiOptions& options)
{
    command
        .add_option("--tolerance",
                    options.tolerance,
                    "largest gap of a contact, an absolute distance, mesh units")
        ->type_name("D")
        ->check(distance(false))
        ->capture_default_str();
    command
        .add_option("--minimum-separation",
                    options.minimumSeparation,
                    "distance that the surfaces must keep, mesh units")
        ->type_name("D")
        ->check(distance(true))
        ->capture_default_str();
    command
        .add_option_function<std::string>(
            "--strategy",
            [&options](const std::string& text)
            {
                for (const auto& [name, value] : kStrategies)
                {
                    options.strategy = name == text ? value : options.strategy;
                }
            },
            "c2a, interval or best-first; all give the same guarantees")
        ->type_name("NAME")
        ->check(oneOf({"c2a", "interval", "best-first"}))
        ->default_str(strategyName(options.strategy));
    command
        .add_option("--max-iterations",
                    options.maxIterations,
                    "pairs examined after which a query gives up")
        ->type_name("N")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000'000'000}))
        ->capture_default_str();
}
}  // namespace bullet_ccd::tools
