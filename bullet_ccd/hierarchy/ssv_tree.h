/// Bounding-volume hierarchy of a triangle mesh, built once and shared by all queries.
///
/// Every node holds a swept-sphere volume: a core (point, line segment, rectangle or box, by how
/// many of its half-extents are zero) swept by a ball. Nodes are flat, up to four siblings
/// adjacent, 64 bytes, single precision rounded outwards; triangles keep their double-precision
/// vertices.
///
/// The data flow: ssv_split orders the triangles and decides which are below which node, ssv_fit
/// encloses the triangles of one node, ssv_tree puts the two together; refit() repeats the second
/// half only. ssv_tree_file keeps the result on disk.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_node.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Largest number of children of a node.
constexpr std::int32_t kArity = 4;

/// What the nodes of a hierarchy are.
enum class SsvKind : std::uint8_t
{
    Box,             ///< oriented box, no ball
    RoundedBox,      ///< box core, with the ball that makes the surface smallest; may be none
    SweptRectangle,  ///< rectangle core
    SweptLine,       ///< line segment core
    SweptPoint,      ///< ball
    Cheapest,  ///< at every node the smallest core whose surface is at most a tenth above the best
};

struct SsvOptions
{
    SsvKind kind = SsvKind::RoundedBox;
};

/// Hierarchy over a mesh of which it keeps its own copy. Immutable but for refit().
class BULLET_CCD_API SsvTree
{
public:
    /// Node 0 is the root. Never empty. Children come after their parent.
    [[nodiscard]] std::span<const SsvNode> nodes() const { return m_nodes; }
    [[nodiscard]] const TriangleMesh& mesh() const { return m_mesh; }
    [[nodiscard]] const SsvOptions& options() const { return m_options; }
    /// Origin of the tree's frame in the mesh's: the middle of its bounds, so that single precision
    /// is spent on the size of the mesh and not on its place [m].
    [[nodiscard]] const Eigen::Vector3d& origin() const { return m_origin; }
    /// The three corners of the triangle in a leaf's slot, in the tree's frame [m]. Slots are in
    /// the order of the leaves, so that triangles near each other in space are so in memory.
    [[nodiscard]] const std::array<Eigen::Vector3d, 3>& corners(std::int32_t slot) const
    {
        return m_corners[static_cast<std::size_t>(slot)];
    }
    /// The same for a triangle of mesh().
    [[nodiscard]] std::array<Eigen::Vector3d, 3> cornersOfTriangle(std::int32_t triangle) const;
    /// Index in mesh() of the triangle in a slot.
    [[nodiscard]] std::int32_t triangle(std::int32_t slot) const
    {
        return m_triangles[static_cast<std::size_t>(slot)];
    }
    /// Largest distance of a vertex of a triangle from origin() [m].
    [[nodiscard]] double radius() const { return m_radius; }

    /// Moves the vertices of mesh(): the same triangles below the same nodes, every volume fitted
    /// anew and as tight as one that is built for the same triangles; origin() moves along. A query
    /// stays right for any deformation, but slows down where triangles that were neighbours part.
    /// Throws std::invalid_argument, and changes nothing, if the number of vertices differs or one
    /// is not finite.
    void refit(std::span<const Eigen::Vector3d> vertices);

    friend SsvTree buildSsvTree(TriangleMesh mesh, const SsvOptions& options);
    friend SsvTree loadSsvTree(TriangleMesh mesh,
                               const SsvOptions& options,
                               const std::filesystem::path& path);

private:
    SsvTree(TriangleMesh mesh, const SsvOptions& options);
    void placeCorners();

    TriangleMesh m_mesh;
    SsvOptions m_options;
    std::vector<SsvNode> m_nodes;
    std::vector<std::array<Eigen::Vector3d, 3>> m_corners;
    std::vector<std::int32_t> m_triangles;
    Eigen::Vector3d m_origin = Eigen::Vector3d::Zero();
    double m_radius = 0.0;
};

/// Builds the hierarchy top-down, one triangle a leaf; O(n log n), on all threads for large meshes.
/// The result does not depend on their number.
/// Throws std::invalid_argument if the mesh is empty, has indices out of range or coordinates that
/// are not finite (see checkMesh).
[[nodiscard]] BULLET_CCD_API SsvTree buildSsvTree(TriangleMesh mesh,
                                                  const SsvOptions& options = {});
}  // namespace bullet_ccd
