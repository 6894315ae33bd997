/// The verbs of the program `grasp`. Each adds itself to the command line; when it is chosen it
/// runs and leaves its exit code.
#pragma once

#include "grasp/planner/grasp_planner.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <string>

namespace bullet_ccd::tools
{
enum ExitCode
{
    kFound = 0,
    kNothingFound = 1,  ///< no grasp, or a check or criterion that failed
    kUsage = 2,
    kBadInput = 3,
};

void addPlanCommand(CLI::App& app, int& exitCode);
void addCheckCommand(CLI::App& app, int& exitCode);
void addHandCommand(CLI::App& app, int& exitCode);
void addTableCommand(CLI::App& app, int& exitCode);

/// Accepts values from low to high, so never nan, which CLI::Range lets pass; the range shows in
/// errors, not in the help.
template <typename T>
[[nodiscard]] CLI::Validator within(T low, T high)
{
    return {[low, high](const std::string& text)
            {
                T value{};
                const bool fits =
                    CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
                return fits ? std::string()
                            : fmt::format("{} is not a number from {} to {}", text, low, high);
            },
            ""};
}

/// Options that plan and table share: candidates, seed, jobs, quality.
void addPlannerOptions(CLI::App& command, grasp::PlannerOptions& options);
}  // namespace bullet_ccd::tools
