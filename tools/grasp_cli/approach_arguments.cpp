#include "tools/grasp_cli/commands.h"
#include "tools/grasp_cli/path_file.h"

#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
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
}  // namespace bullet_ccd::tools
