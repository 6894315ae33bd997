/// Bounding-volume hierarchy of a triangle mesh, built once and shared by all queries.
///
/// Every node holds a swept-sphere volume: a core (point, line segment, rectangle or box, by how
/// many of its half-extents are zero) swept by a ball. Nodes are flat, siblings adjacent, 64 bytes,
/// single precision rounded outwards; triangles keep their double-precision vertices.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Volume {center + sum_k s_k axis_k + b : |s_k| <= half_k, |b| <= radius}, in the tree's own
/// frame: the mesh's, moved so that SsvTree::origin() is its origin. axis_2 = axis_0 x axis_1. The
/// axes are unit and orthogonal to single precision only; what that costs is part of the
/// half-extents.
struct SsvNode
{
    float center[3];        // 12 bytes
    float axis0[3];         // 12
    float axis1[3];         // 12
    float half[3];          // 12
    float radius;           // 4
    float coreRadius;       // 4: |half|, the circumscribed radius of the core, rounded up
    std::int32_t child;     // 4: first of two adjacent children, or kNone for a leaf
    std::int32_t triangle;  // 4: the leaf's triangle, kNone inside

    [[nodiscard]] bool isLeaf() const { return child == kNone; }
};
static_assert(sizeof(SsvNode) == 64);

/// Immutable hierarchy over a mesh of which it keeps its own copy.
class SsvTree
{
public:
    /// Node 0 is the root. Never empty.
    [[nodiscard]] std::span<const SsvNode> nodes() const { return m_nodes; }
    [[nodiscard]] const TriangleMesh& mesh() const { return m_mesh; }
    /// Origin of the tree's frame in the mesh's: the middle of its bounds, so that single precision
    /// is spent on the size of the mesh and not on its place [m].
    [[nodiscard]] const Eigen::Vector3d& origin() const { return m_origin; }
    /// The three corners of triangle `index` of mesh(), in the tree's frame [m].
    [[nodiscard]] const std::array<Eigen::Vector3d, 3>& corners(std::int32_t index) const
    {
        return m_corners[static_cast<std::size_t>(index)];
    }
    /// Largest distance of a vertex from origin() [m].
    [[nodiscard]] double radius() const { return m_radius; }

    friend SsvTree buildSsvTree(TriangleMesh mesh);

private:
    TriangleMesh m_mesh;
    std::vector<SsvNode> m_nodes;
    std::vector<std::array<Eigen::Vector3d, 3>> m_corners;
    Eigen::Vector3d m_origin = Eigen::Vector3d::Zero();
    double m_radius = 0.0;
};

/// Builds the hierarchy top-down, one triangle a leaf; O(n log n).
/// Throws std::invalid_argument if the mesh is empty, has indices out of range or coordinates that
/// are not finite (see checkMesh).
[[nodiscard]] SsvTree buildSsvTree(TriangleMesh mesh);
}  // namespace bullet_ccd
