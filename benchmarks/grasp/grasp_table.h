/// Plans of every hand with every object, beside each other and judged.
#pragma once

#include "grasp/planner/grasp_planner.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct TableOptions
{
    std::vector<std::string> hands;    ///< files, or names of shipped ones
    std::vector<std::string> objects;  ///< the same
    double objectScale = 1.0;
    std::filesystem::path output;  ///< folder for the table and all grasps; empty: none
    bool quiet = false;
    grasp::PlannerOptions planner;
};

inline constexpr const char* kTableCriteria =
    "Contacts, links and fingers are means (fingers: the minimum) over the force closures;\n"
    "penetration and gaps are measured over all final postures by the independent check.\n"
    "\n"
    "Below the table each criterion is marked pass or FAIL; exit code 1 if any fails:\n"
    "  each hand finds a force closure; with three fingers or more, these have 3 contacts or\n"
    "  more in the mean; with fewer, two fingers or more touch in every one of them\n"
    "  three quarters of the hands find force closure on two thirds of the objects or more\n"
    "  no final posture penetrates the object\n"
    "  no contact is wider than 0.2 mm";

/// Prints a row as soon as its pair is planned, then the criteria.
/// @return whether all of them hold
/// Throws std::runtime_error for names that are unknown and files that cannot be written.
[[nodiscard]] bool tableGrasps(const TableOptions& options);
}  // namespace bullet_ccd::benchmarks
