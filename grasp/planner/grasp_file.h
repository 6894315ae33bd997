/// Grasps as JSON Lines: one self-contained record a line, schema versioned.
#pragma once

#include "grasp/planner/grasp_planner.h"

#include <filesystem>
#include <iosfwd>
#include <span>

namespace bullet_ccd::grasp
{
/// Written to "schema" of every record.
inline constexpr const char* kGraspSchema = "bullet_ccd.grasp/1";

/// What is common to the grasps of one run.
struct GraspRun
{
    std::filesystem::path handFile;
    std::filesystem::path srdfFile;  ///< empty: none
    std::filesystem::path objectFile;
    double objectScale = 1.0;
    PlannerOptions options;
};

void writeGrasps(std::ostream& out,
                 const GraspRun& run,
                 const HandModel& hand,
                 const GraspObject& object,
                 std::span<const Grasp> grasps);

struct GraspRecord
{
    GraspRun run;
    Grasp grasp;
};

/// Reads them back. Throws std::runtime_error: "<file>:<line>: <what>: <remedy>".
[[nodiscard]] std::vector<GraspRecord> readGrasps(const std::filesystem::path& path);
}  // namespace bullet_ccd::grasp
