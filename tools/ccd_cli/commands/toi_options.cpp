#include "bullet_ccd/reduce/reduce_mesh.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/support/option_values.h"
#include "tools/support/pose_text.h"

#include <cstdint>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
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

void addMeshes(CLI::App& command, std::string& fileA, std::string& fileB)
{
    command.add_option("A", fileA, "The mesh of body A.")->type_name("MESH")->required();
    command.add_option("B", fileB, "The mesh of body B.")->type_name("MESH")->required();
}

void addDistanceOptions(CLI::App& command, double& tolerance, double& minimumSeparation)
{
    command
        .add_option("--tolerance",
                    tolerance,
                    "How large the gap of a reported contact may be, an absolute distance "
                    "[unit of the meshes].")
        ->type_name("D")
        ->check(distance(false))
        ->capture_default_str();
    command
        .add_option("--minimum-separation",
                    minimumSeparation,
                    "The distance that the surfaces must keep [unit of the meshes].")
        ->type_name("D")
        ->check(distance(true))
        ->capture_default_str();
}

void addDepthOptions(CLI::App& command, ElementaryDepth& depth)
{
    CLI::Option* exact = command.add_flag_callback(
        "--exact",
        [&depth] { depth = ElementaryDepth::Exact; },
        "Decide without rounding whether features touch, or come within the minimum separation: "
        "no hit is false.");
    command
        .add_flag_callback(
            "--decide",
            [&depth] { depth = ElementaryDepth::Decide; },
            "Follow what comes within the tolerance: most such pairs then prove to pass.")
        ->excludes(exact);
}

void checkAccuracy(const ToiOptions& options, const TriangleMesh& mesh)
{
    const double smallest = smallestAccuracy(mesh);
    if (options.anyWithin && !(options.tolerance >= smallest))
    {
        throw std::invalid_argument(
            fmt::format("--accuracy {}: the smallest for a mesh of this size and place is {:.2g}: "
                        "less is lost in the rounding of its coordinates",
                        options.tolerance,
                        smallest));
    }
}

void addToiOptions(CLI::App& command, ToiOptions& options)
{
    addDistanceOptions(command, options.tolerance, options.minimumSeparation);
    command
        .add_option_function<double>(
            "--accuracy",
            [&options, tolerance = command.get_option("--tolerance")](double accuracy)
            {
                if (tolerance->count() > 0 && options.tolerance != accuracy)
                {
                    throw CLI::ValidationError(
                        "--accuracy",
                        fmt::format("{} is not the --tolerance of {}, and both are one number: "
                                    "leave one out",
                                    accuracy,
                                    options.tolerance));
                }
                options.tolerance = accuracy;
                options.anyWithin = true;
            },
            "In place of --tolerance: any contact within this gap will do. Nothing is looked at "
            "more closely than that asks for, and times may be earlier by what it takes to close "
            "the gap [unit of the meshes].")
        ->type_name("D");
    command
        .add_option("--strategy",
                    options.strategy,
                    "How to search: c2a, interval or best-first. All give the same guarantees.")
        ->type_name("NAME")
        ->transform(wordFor<ToiStrategy>({{"c2a", ToiStrategy::C2A},
                                          {"interval", ToiStrategy::Interval},
                                          {"best-first", ToiStrategy::BestFirst}}))
        ->default_str("best-first");
    command
        .add_option("--max-iterations",
                    options.maxIterations,
                    "How many pairs of nodes and triangles a query examines before it gives up.")
        ->type_name("N")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000'000'000}))
        ->capture_default_str();
}
}  // namespace bullet_ccd::tools
