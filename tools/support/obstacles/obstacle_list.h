/// What stands around a robot.
#pragma once

#include "bullet_ccd/toi/rigid_toi.h"

#include <Eigen/Geometry>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct Obstacle
{
    std::string name;
    std::shared_ptr<const SsvTree> tree;  ///< shared by obstacles of one file and scale
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

/// Obstacles, but for those that nothing reaches.
struct ObstacleList
{
    std::vector<Obstacle> inReach;
    std::size_t outOfReach = 0;           ///< whose meshes were never loaded
    std::size_t trianglesOutOfReach = 0;  ///< of the meshes that only those have, each once
};

/// The same as loadObstacles(), but of the obstacles of manifests (scene_manifest.h) only those are
/// loaded whose boxes meet one of `reach` (W [m]). Throws std::runtime_error as well if a mesh is
/// not the one that the manifest was made of; a file that is out of reach and older than the
/// manifest is only asked for its size.
[[nodiscard]] ObstacleList loadObstaclesWithin(std::span<const std::string> files,
                                               std::span<const Eigen::AlignedBox3d> reach);

/// Obstacles from files: a mesh rests at the origin; a file that ends in .csv, .yaml or .yml is a
/// scene, see obstacle_scene.h. Throws as its readers and, with the place in the scene before it,
/// as loadMeshFile().
[[nodiscard]] std::vector<Obstacle> loadObstacles(std::span<const std::string> files);

/// The same as a query takes them, at rest. They refer to the hierarchies.
[[nodiscard]] std::vector<RigidBody> bodiesOf(std::span<const Obstacle> obstacles);
}  // namespace bullet_ccd::tools
