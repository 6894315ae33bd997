/// The parts of a binary glTF 2.0 file: materials, meshes, a tree of named nodes.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/report/raster.h"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <tiny_gltf.h>
#include <vector>

namespace bullet_ccd::grasp
{
/// Materials, meshes and nodes go by the index that adding them returns.
class BULLET_CCD_API GltfBuilder
{
public:
    GltfBuilder();

    /// `color` as on screen (sRGB), as the pictures have it; below 1 the opacity makes it blend.
    int addMaterial(const std::string& name, const Color& color, float opacity);
    /// A corner's normal is kept: a vertex is written once for every normal that it has.
    int addTriangles(const std::string& name, const Shape& shape, int material);
    int addLines(const std::string& name,
                 std::span<const Eigen::Vector3f> points,
                 std::span<const std::array<std::uint32_t, 2>> lines,
                 int material);
    /// @param parent  node, or kNone: a root of the scene
    int addNode(const std::string& name, int parent);
    /// The mesh (or kNone), scaled in its own axes, then moved to `pose` in the parent.
    int addNode(const std::string& name,
                int parent,
                int mesh,
                const Eigen::Isometry3d& pose,
                const Eigen::Vector3d& scale = Eigen::Vector3d::Ones());

    /// Moves a node through poses in its parent at increasing times [s], linearly in between. All
    /// nodes that move make up one animation.
    void animate(int node, std::span<const float> times, std::span<const Eigen::Isometry3d> poses);

    /// Throws std::runtime_error "<file>: <what>: <remedy>".
    void write(const std::filesystem::path& file) const;

private:
    template <typename T>
    int addView(std::span<const T> values, int target);
    int addPoints(std::span<const Eigen::Vector3f> points);
    int addVectors(std::span<const Eigen::Vector3f> vectors);
    int addIndices(std::span<const std::uint32_t> indices);
    int addNumbers(std::span<const float> numbers, std::size_t count, int type);
    int addMesh(const std::string& name, tinygltf::Primitive primitive);

    tinygltf::Model m_model;
};
}  // namespace bullet_ccd::grasp
