/// Scenes of obstacles in text files: which mesh stands where.
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// What a manifest says of a mesh.
struct MeshFacts
{
    Eigen::AlignedBox3d box{};  ///< of the mesh, in its own frame [m]
    std::size_t triangles = 0;
    std::uint64_t bytes = 0;  ///< of the file
    std::uint64_t hash = 0;   ///< of the file
};

struct PlacedMesh
{
    std::filesystem::path mesh;
    std::optional<Eigen::Vector3d> box{};  ///< its extents [m], in place of a mesh
    std::string name;                      ///< if the scene gives none, that of the mesh file
    double scale = 1.0;
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    std::string where;                 ///< "<file>:<line>: mesh: " of the scene
    std::optional<MeshFacts> facts{};  ///< if the scene is a manifest
};

/// A row an obstacle, of the columns
///
///   mesh   file, relative to the scene's folder
///   name   if absent, that of the file
///   scale  file units to those of the robot, default 1
///   qw qx qy qz tx ty tz  pose, all or none, default identity
///
/// and in a manifest (scene_manifest.h) those of MeshFacts, all or none.
///
/// Throws std::runtime_error "<file>:<line>: <column>: <what, value>: <remedy>".
[[nodiscard]] std::vector<PlacedMesh> readCsvScene(const std::filesystem::path& path);

/// A list `obstacles` of maps with the keys mesh, name and scale as above and
///
///   position    [tx, ty, tz], default 0
///   quaternion  [qw, qx, qy, qz], or
///   rpy         [roll, pitch, yaw] about the fixed axes x, y, z in that order, as in URDF [rad]
///
/// or `box`, three extents [m], in place of the mesh. A mesh may also be the name of an object that
/// ships. `objects` is another such list, and `robot` and `target` are left to those who plan
/// tasks. If all that is asked of the scene is to be within an accuracy [m], it has the key
/// `accuracy`.
///
/// Throws std::runtime_error as above, for keys that do not exist too.
[[nodiscard]] std::vector<PlacedMesh> readYamlScene(const std::filesystem::path& path);

/// The accuracy that scenes in YAML state; none if none does. Throws std::runtime_error as above,
/// and if one of them states another than the next, or than whoever names the scenes.
[[nodiscard]] std::optional<double> accuracyOf(std::span<const std::string> files,
                                               std::optional<double> stated);

/// True if the ending says that the file is a scene: .csv, .yaml or .yml.
[[nodiscard]] bool isScene(const std::filesystem::path& path);

/// One of both, by its ending.
[[nodiscard]] std::vector<PlacedMesh> readScene(const std::filesystem::path& path);
}  // namespace bullet_ccd::tools
