/// Scenes of obstacles in text files: which mesh stands where.
#pragma once

#include <Eigen/Geometry>

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct PlacedMesh
{
    std::filesystem::path mesh;
    std::string name;  ///< if the scene gives none, that of the mesh file
    double scale = 1.0;
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    std::string where;  ///< "<file>:<line>: mesh: " of the scene
};

/// A row an obstacle, of the columns
///
///   mesh   file, relative to the scene's folder
///   name   if absent, that of the file
///   scale  file units to those of the robot, default 1
///   qw qx qy qz tx ty tz  pose, all or none, default identity
///
/// Throws std::runtime_error "<file>:<line>: <column>: <what, value>: <remedy>".
[[nodiscard]] std::vector<PlacedMesh> readCsvScene(const std::filesystem::path& path);

/// A list `obstacles` of maps with the keys mesh, name and scale as above and
///
///   position    [tx, ty, tz], default 0
///   quaternion  [qw, qx, qy, qz], or
///   rpy         [roll, pitch, yaw] about the fixed axes x, y, z in that order, as in URDF [rad]
///
/// Throws std::runtime_error as above, for keys that do not exist too.
[[nodiscard]] std::vector<PlacedMesh> readYamlScene(const std::filesystem::path& path);
}  // namespace bullet_ccd::tools
