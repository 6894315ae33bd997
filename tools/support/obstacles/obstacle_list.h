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

/// Obstacles from files: a mesh rests at the origin; a file that ends in .csv, .yaml or .yml is a
/// scene, see obstacle_scene.h. Throws as its readers and, with the place in the scene before it,
/// as loadMeshFile().
[[nodiscard]] std::vector<Obstacle> loadObstacles(std::span<const std::string> files);

/// The same as a query takes them, at rest. They refer to the hierarchies.
[[nodiscard]] std::vector<RigidBody> bodiesOf(std::span<const Obstacle> obstacles);
}  // namespace bullet_ccd::tools
