/// Meshes as text that a page reads fast: positions in 16 bits, everything in base64.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <string>

namespace bullet_ccd::grasp
{
/// Vertex k is origin + step * (its three numbers, component by component) [m]. `step` is 1/65535
/// of the size of the mesh's box along each axis, so a coordinate is off by half of it at most.
struct PackedMesh
{
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    std::string points;     ///< base64 of little-endian uint16, three a vertex
    std::string triangles;  ///< base64 of little-endian uint32, three a triangle

    bool operator==(const PackedMesh& other) const = default;
};
[[nodiscard]] PackedMesh packMesh(const TriangleMesh& mesh);

/// RFC 4648 with padding.
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);
}  // namespace bullet_ccd::grasp
