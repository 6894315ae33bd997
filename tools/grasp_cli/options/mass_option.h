/// --mass, which `plan`, `force`, `trial` and `task` have in common.
#pragma once

#include "grasp/quality/object_mass.h"
#include "tools/grasp_cli/inputs/grasp_records.h"
#include "tools/support/option_values.h"

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

namespace bullet_ccd::tools
{
/// What happens without it, where no plan says the mass.
inline constexpr const char* kMassDefault =
    "Default: its volume at 1000 kg/m3, as of water; if its mesh is not closed, that of its convex "
    "hull.";

/// @param least  that it takes [kg]
inline CLI::Option* addMassOption(CLI::App& command,
                                  std::optional<double>& mass,
                                  double least,
                                  const std::string& text)
{
    constexpr double kMost = 1e6;  // [kg]
    return command.add_option("--mass", mass, text)->type_name("KG")->check(within(least, kMost));
}

/// The given mass, or else that of the plan.
inline grasp::ObjectMass massOf(const GraspRecords& records, const std::optional<double>& given)
{
    return grasp::massOf(records.object.object, given ? given : records.source.run.options.mass);
}
}  // namespace bullet_ccd::tools
