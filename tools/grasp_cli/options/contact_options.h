/// Options of what contacts can pass on, shared by `grasp force` and `grasp quality`.
#pragma once

#include "grasp/grasp_types.h"
#include "grasp/planner/grasp_planner.h"

#include <CLI/CLI.hpp>
#include <optional>

namespace bullet_ccd::tools
{
struct ContactArguments
{
    std::optional<double> friction;  ///< else that of the plan
    grasp::ContactModel model = grasp::ContactModel::HardFinger;
    double torsion = grasp::ContactLaw{}.torsion;  ///< [m]
};

/// Adds --friction, --model and --torsion.
void addContactOptions(CLI::App& command, ContactArguments& arguments);

[[nodiscard]] grasp::ContactLaw contactLaw(const ContactArguments& arguments,
                                           const grasp::PlannerOptions& plan);
}  // namespace bullet_ccd::tools
