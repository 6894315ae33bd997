/// Where the flat faces of a mesh are, in double precision: volumes in single precision blur it,
/// and where flat lies on flat nothing else decides.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
struct SsvNode;

/// low <= n.x <= high for all points x of some triangles along a unit direction n [m].
struct Slab
{
    double low;
    double high;
};

/// The normals of the largest faces, and how far every node of a hierarchy reaches along them.
///
/// Guarantee: slabs are exact up to a few roundings of double precision. A normal belongs to at
/// least kLeastTriangles triangles of a sample of the mesh; a curved mesh has none.
struct FaceSlabs
{
    static constexpr std::size_t kMostNormals = 3;
    static constexpr std::int32_t kLeastTriangles = 8;

    std::vector<Eigen::Vector3d> normals{};  ///< unit, in the frame of the tree
    std::vector<Slab> slabs{};               ///< for every node one along every normal

    [[nodiscard]] bool empty() const { return normals.empty(); }
    [[nodiscard]] std::span<const Slab> ofNode(std::int32_t node) const
    {
        return std::span(slabs).subspan(static_cast<std::size_t>(node) * normals.size(),
                                        normals.size());
    }
};

/// @param corners of the triangles in the slots of the leaves
[[nodiscard]] FaceSlabs findFaceSlabs(std::span<const SsvNode> nodes,
                                      std::span<const std::array<Eigen::Vector3d, 3>> corners);
}  // namespace bullet_ccd
