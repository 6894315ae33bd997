/// Hands and objects by path or by the name under which the project ships them.
#pragma once

#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"
#include "tools/support/obstacles/share_folder.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// A page in three dimensions without its data, of grasps or of tasks; empty if it was not built.
inline constexpr const char* kTaskViewer = "task_viewer.html";
[[nodiscard]] std::filesystem::path viewerFile(const std::string& name = "viewer.html");

/// Folder for what was found of hands and need not be found again: $BULLET_CCD_CACHE if it is set
/// (to nothing: no folder), else bullet_ccd in $XDG_CACHE_HOME, else in ~/.cache. It may not exist
/// yet. Empty if there is none.
[[nodiscard]] std::filesystem::path cacheFolder();

/// Names of what ships: robots/<name>/<name>.urdf and objects/<name>.obj, sorted.
[[nodiscard]] std::vector<std::string> shippedHands(const std::filesystem::path& share);
[[nodiscard]] std::vector<std::string> shippedObjects(const std::filesystem::path& share);

/// A path that exists as it is, else a shipped name.
/// Throws std::runtime_error that lists the known names.
[[nodiscard]] std::filesystem::path resolveHand(const std::string& nameOrPath);
[[nodiscard]] std::filesystem::path resolveObject(const std::string& nameOrPath);

/// What was loaded and what a user should know about it, one line each.
struct LoadedHand
{
    grasp::HandModel hand;
    std::filesystem::path file;
};
struct LoadedObject
{
    grasp::GraspObject object;
    std::filesystem::path file;
    std::vector<std::string> notes;
};

/// Files are absolute, also HandModel::srdfFile.
/// Throw std::runtime_error "<file>: <what>: <remedy>".
/// @param srdf  in place of the one beside the URDF or the one that ships; empty: none
[[nodiscard]] LoadedHand loadNamedHand(const std::string& nameOrPath,
                                       const std::filesystem::path& srdf = {});
[[nodiscard]] LoadedObject loadNamedObject(const std::string& nameOrPath, double scale);
}  // namespace bullet_ccd::tools
