/// What the search for contacts has to know about a mesh beforehand: which features its triangles
/// meet at, and how the surface bends there. Built once per hierarchy and read by all queries, or
/// for one query of those triangles only that are near the other body.
///
/// Every vertex and every edge belongs to one of the triangles around it, its owner: a pair of
/// features that is near is found exactly once, at the pair of their owners. A direction n is in
/// the cone of a feature if the surface around it lies below the plane across n there: then the
/// feature is the nearest of its surface to points in that direction. Surfaces have two sides and
/// need neither be closed nor consistently wound.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// A point this near to an edge, relative to the height of the triangle over it, lies on the edge.
inline constexpr double kOnBoundary = 1e-9;

/// Vertices at exactly the same position are one.
class BULLET_CCD_API ContactSurface
{
public:
    /// One triangle; bit k of a mask is corner k or the edge from corner k to the next.
    struct Slot
    {
        std::array<std::int32_t, 3> vertices{kNone, kNone, kNone};
        std::array<std::int32_t, 3> edges{kNone, kNone, kNone};  ///< kNone: of no length
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();        ///< unit; zero without area
        std::int32_t inTree = kNone;                             ///< the slot of the tree
        std::uint8_t ownVertices = 0;  ///< that this triangle owns and that are not flat
        std::uint8_t ownEdges = 0;
        std::uint8_t sharpEdges = 0;  ///< that are not flat, owned or not
        std::uint8_t flatEdges = 0;   ///< owned and flat
    };

    /// The whole mesh; its slots are those of the tree.
    /// @param tree must outlive this; after SsvTree::refit() a new one is needed
    explicit ContactSurface(const SsvTree& tree);
    /// A part of the mesh: slot i is slot `inTree[i]` of the tree. What is said of a feature is
    /// right if all triangles that meet there are in the part.
    ContactSurface(const SsvTree& tree, std::span<const std::int32_t> inTree);

    [[nodiscard]] const SsvTree& tree() const { return *m_tree; }
    [[nodiscard]] std::span<const Slot> slots() const { return m_slots; }
    [[nodiscard]] const Slot& slot(std::int32_t i) const
    {
        return m_slots[static_cast<std::size_t>(i)];
    }
    /// In the tree's frame.
    [[nodiscard]] std::array<Eigen::Vector3d, 3> corners(std::int32_t i) const
    {
        return m_tree->corners(slot(i).inTree);
    }
    /// Index in the mesh.
    [[nodiscard]] std::int32_t triangle(std::int32_t i) const
    {
        return m_tree->triangle(slot(i).inTree);
    }
    /// The smallest index in the mesh of all that are this vertex.
    [[nodiscard]] std::int32_t meshVertex(std::int32_t vertex) const
    {
        return m_meshVertices[static_cast<std::size_t>(vertex)];
    }
    /// Unit directions in the surface from the vertex: its edges, and more in obtuse corners.
    [[nodiscard]] std::span<const Eigen::Vector3f> aroundVertex(std::int32_t vertex) const
    {
        return range(m_vertexDirections, m_vertexFirst, vertex);
    }
    /// Unit directions from the edge into its triangles, at right angles to it.
    [[nodiscard]] std::span<const Eigen::Vector3f> aroundEdge(std::int32_t edge) const
    {
        return range(m_edgeDirections, m_edgeFirst, edge);
    }
    /// The surface bends by less than 0.2 rad there, as where facets stand for something round.
    [[nodiscard]] bool isSmooth(std::int32_t edge) const
    {
        return m_smooth[static_cast<std::size_t>(edge)] != 0;
    }

private:
    struct Edges;

    static std::span<const Eigen::Vector3f> range(const std::vector<Eigen::Vector3f>& all,
                                                  const std::vector<std::int32_t>& first,
                                                  std::int32_t i)
    {
        const auto at = static_cast<std::size_t>(i);
        return std::span(all).subspan(static_cast<std::size_t>(first[at]),
                                      static_cast<std::size_t>(first[at + 1] - first[at]));
    }
    void mergeVertices();
    void placeEdges(Edges& edges);
    void bendEdges(Edges& edges);
    void placeVertexDirections(const Edges& edges);
    void assignOwners(const Edges& edges);

    const SsvTree* m_tree;
    std::vector<Slot> m_slots;
    std::vector<std::int32_t> m_meshVertices;
    std::vector<std::int32_t> m_vertexFirst;
    std::vector<Eigen::Vector3f> m_vertexDirections;
    std::vector<std::int32_t> m_edgeFirst;
    std::vector<Eigen::Vector3f> m_edgeDirections;
    std::vector<std::uint8_t> m_smooth;
};
}  // namespace bullet_ccd
