/// Pictures and the page that shows them.
#pragma once

#include "grasp/planner/grasp_file.h"

#include <filesystem>
#include <span>

namespace bullet_ccd::grasp
{
struct PictureOptions
{
    int width = 1200;  ///< pixels; two views side by side
    int height = 640;
};

/// Renders hand, object and contacts (points and normals) of a grasp to a PNG: two views, shaded,
/// hidden surfaces removed, the object see-through enough that contacts behind it are found.
void drawGrasp(const HandModel& hand,
               const GraspObject& object,
               const Grasp& grasp,
               const PictureOptions& options,
               const std::filesystem::path& file);

/// One HTML page: the run, a table of all grasps, the pictures of the best. Works from a file.
void writeReport(const GraspRun& run,
                 const HandModel& hand,
                 const GraspObject& object,
                 std::span<const Grasp> grasps,
                 std::span<const std::filesystem::path> pictures,
                 const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
