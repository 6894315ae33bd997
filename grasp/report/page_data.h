/// What is handed to pages in three dimensions: meshes, poses and colours as JSON, and templates.
#pragma once

#include "grasp/report/packed_mesh.h"
#include "grasp/report/raster.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
using PageJson = nlohmann::ordered_json;

/// To six decimals: enough for a picture.
[[nodiscard]] double rounded(double value);

/// x, y, z, qw, qx, qy, qz, with all digits.
[[nodiscard]] PageJson poseList(const Eigen::Isometry3d& X);

/// Such as "#2f6690".
[[nodiscard]] std::string hexColor(const Color& color);

/// Equal meshes are kept once.
class MeshList
{
public:
    /// Index of the mesh.
    std::size_t add(const TriangleMesh& mesh);
    [[nodiscard]] PageJson json() const;

private:
    std::vector<PackedMesh> m_meshes;
};

/// For a script element: nothing in it looks like its end.
[[nodiscard]] std::string scriptText(const PageJson& json);

/// The template with texts in the places of its marks, each of which it has once and in this order.
/// Throws std::runtime_error "<file>: <what>: <remedy>" if it cannot be read or is something else.
[[nodiscard]] std::string filledTemplate(
    const std::filesystem::path& file,
    const std::vector<std::pair<std::string, std::string>>& marks);
}  // namespace bullet_ccd::grasp
