/// Scenes of tasks: what stands where, what can be taken, and where it is to go.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
struct TaskBody
{
    std::string name;
    std::shared_ptr<const SsvTree> tree;
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

struct TaskScene
{
    std::filesystem::path file;
    Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();
    std::vector<std::pair<std::string, double>> start;  ///< positions of joints by name
    std::vector<TaskBody> obstacles;
    std::vector<TaskBody> objects;
    Eigen::Vector3d targetCenter = Eigen::Vector3d::Zero();
    Eigen::Vector2d targetSize = Eigen::Vector2d::Zero();
};

/// A YAML map of
///
///   robot      position, and quaternion or rpy, of the root of the arm (default: the origin), and
///              start, a map of joints and their positions (default: 0, within the limits)
///   obstacles  a list of bodies
///   objects    a list of bodies that can be taken; the others stand in the way
///   target     position of the middle of a level rectangle, and its size along x and y
///
/// A body has a name (default: that of its mesh), a pose as above, and `box`, its extents, or
/// `mesh`, a file relative to the scene or the name of an object that ships, and perhaps `scale`.
/// Metres and radians; z is up.
///
/// Throws std::runtime_error "<file>:<line>: <key>: <what, value>: <remedy>".
[[nodiscard]] TaskScene readTaskScene(const std::filesystem::path& path);

/// Renders obstacles and objects to a PNG, from two sides. Throws std::runtime_error if it cannot
/// be written.
void drawScene(const TaskScene& scene, const std::filesystem::path& file);

/// A path that exists as it is, else robots/scenes/<name>.yaml, or robots/arms/<name>.urdf, of what
/// ships. Throw std::runtime_error.
[[nodiscard]] std::filesystem::path resolveScene(const std::string& nameOrPath);
[[nodiscard]] std::filesystem::path resolveArm(const std::string& nameOrPath);
}  // namespace bullet_ccd::tools
