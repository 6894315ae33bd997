/// The part of a mesh that is near another: its triangles in a common frame, which of them meet at
/// a feature, and which features lie inside a flat part. Internal to contactsAt().
#pragma once

#include "bullet_ccd/contact/rigid_contacts.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Weights of the corners below this do not count: a point this near to an edge, relative to the
/// height of the triangle over it, lies on the edge.
inline constexpr double kOnBoundary = 1e-9;

/// The point of a triangle closest to another point.
struct ClosestOnTriangle
{
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    std::array<double, 3> weights{};  ///< barycentric
    double distance = 0.0;
};

/// Degenerate triangles count as the segments or points that they are.
[[nodiscard]] ClosestOnTriangle closestOnTriangle(const Eigen::Vector3d& x,
                                                  const TriangleCorners& corners);

/// Normal of a triangle, or zero if it has no area to speak of.
[[nodiscard]] Eigen::Vector3d unitNormal(const TriangleCorners& corners);

class NearSurface
{
public:
    /// @param X_FG pose of the tree's frame in the common frame F
    /// @param triangles of the mesh, in any order, also repeatedly
    NearSurface(const SsvTree& tree,
                const Eigen::Isometry3d& X_FG,
                std::vector<std::int32_t> triangles);

    /// Triangles are numbered from 0 here, in the order of the mesh.
    [[nodiscard]] std::size_t indexOf(std::int32_t meshTriangle) const;
    [[nodiscard]] std::int32_t meshTriangle(std::size_t i) const { return m_triangles[i]; }
    [[nodiscard]] const TriangleCorners& corners(std::size_t i) const { return m_corners[i]; }
    [[nodiscard]] const Eigen::Vector3d& normal(std::size_t i) const { return m_normals[i]; }

    /// The feature of triangle i inside of which the corners have these weights.
    [[nodiscard]] Feature feature(std::size_t i, const std::array<double, 3>& weights) const;
    /// Triangles that have all vertices of the feature.
    [[nodiscard]] std::vector<std::size_t> around(const Feature& feature) const;
    /// Unit direction of an edge; zero for other features.
    [[nodiscard]] Eigen::Vector3d edgeDirection(const Feature& feature) const;
    /// Mean normal of the surface around a feature, unit; zero if the normals cancel.
    [[nodiscard]] Eigen::Vector3d meanNormal(const Feature& feature) const;

    /// True for edges and vertices that lie inside a flat part of the surface: all triangles
    /// around them lie in one plane but for `offPlane` and an angle of 1e-6, and on all sides.
    [[nodiscard]] bool isFlat(const Feature& feature, double offPlane) const;

private:
    /// A vertex of triangle i.
    [[nodiscard]] const Eigen::Vector3d& corner(std::size_t i, std::int32_t vertex) const;
    [[nodiscard]] bool isFlatEdge(const Feature& edge, double offPlane) const;

    std::vector<std::int32_t> m_triangles;
    std::vector<TriangleCorners> m_corners;
    std::vector<Eigen::Vector3d> m_normals;
    std::vector<Triangle> m_vertices;  ///< of each triangle; equal positions, equal index
    std::vector<std::pair<std::int32_t, std::size_t>> m_around;  ///< (vertex, triangle), sorted
};
}  // namespace bullet_ccd
