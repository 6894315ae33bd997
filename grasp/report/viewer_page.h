/// The page in three dimensions.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/formats/grasp_file.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What a page may show beside hand, object and grasps.
struct PageExtras
{
    std::span<const RigidBody> obstacles = {};  ///< at rest in W
    /// A command line that closes the hand on the object once --pose and --preshape follow; empty:
    /// none is shown.
    std::string command = {};
    /// Names of files to link to: of the run, and of the k-th grasp.
    std::vector<std::string> files = {};
    std::vector<std::vector<std::string>> graspFiles = {};
};

/// One HTML page that needs nothing but itself: hand, object, contacts with friction cones,
/// obstacles and swept boxes in three dimensions, the motion of every grasp from its start to its
/// end, and a table of all grasps. README.md in this folder lists what is handed to the page.
/// @param grasps    best first
/// @param viewer    the page without its data, as the build makes it: share/bullet_ccd/viewer.html
/// Throws std::runtime_error "<file>: <what>: <remedy>" if `viewer` cannot be read or is something
/// else, or if the page cannot be written.
BULLET_CCD_API void writeViewerPage(const GraspRun& run,
                                    const HandModel& hand,
                                    const GraspObject& object,
                                    std::span<const Grasp> grasps,
                                    const PageExtras& extras,
                                    const std::filesystem::path& viewer,
                                    const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
