#include "bullet_ccd/contact/near_surface.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

bool hasArea(const TriangleCorners& c, const Vector3d& normal)
{
    const double longest = std::max(
        {(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(), (c[0] - c[2]).squaredNorm()});
    // A triangle with height below 1e-13 of its length is an edge, as in triangleDistance().
    return normal.squaredNorm() > 1e-26 * longest * longest;
}

Vector3d areaNormal(const TriangleCorners& c)
{
    return (c[1] - c[0]).cross(c[2] - c[0]);
}

/// Index of each vertex of the triangles and the smallest index at its position, by index.
std::vector<std::pair<std::int32_t, std::int32_t>> mergedVertices(
    const TriangleMesh& mesh, const std::vector<std::int32_t>& triangles)
{
    const auto place = [&](std::int32_t vertex)
    {
        const Vector3d& v = mesh.vertices[static_cast<std::size_t>(vertex)];
        return std::tuple(v.x(), v.y(), v.z());
    };
    std::vector<std::pair<std::int32_t, std::int32_t>> merged;
    for (const std::int32_t triangle : triangles)
    {
        for (const std::int32_t vertex : mesh.triangles[static_cast<std::size_t>(triangle)])
        {
            merged.emplace_back(vertex, vertex);
        }
    }
    std::sort(merged.begin(), merged.end());
    merged.erase(std::unique(merged.begin(), merged.end()), merged.end());
    std::stable_sort(merged.begin(),
                     merged.end(),
                     [&](const auto& x, const auto& y) { return place(x.first) < place(y.first); });
    for (std::size_t k = 1; k < merged.size(); ++k)
    {
        if (place(merged[k].first) == place(merged[k - 1].first))
        {
            merged[k].second = merged[k - 1].second;
        }
    }
    std::sort(merged.begin(), merged.end());
    return merged;
}

/// Vertices ascending and once each; their number says what it is.
Feature featureOf(std::array<std::int32_t, 3> vertices)
{
    // Absent vertices sort to the end while they are larger than all others.
    constexpr std::int32_t kLast = std::numeric_limits<std::int32_t>::max();
    std::replace(vertices.begin(), vertices.end(), kNone, kLast);
    std::sort(vertices.begin(), vertices.end());
    auto end = std::unique(vertices.begin(), vertices.end());
    end = std::remove(vertices.begin(), end, kLast);
    std::fill(end, vertices.end(), kNone);
    const auto count = end - vertices.begin();
    return {.kind = count == 1   ? FeatureKind::Vertex
                    : count == 2 ? FeatureKind::Edge
                                 : FeatureKind::Face,
            .vertices = vertices};
}

bool has(const Triangle& triangle, std::int32_t vertex)
{
    return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
}
}  // namespace

ClosestOnTriangle closestOnTriangle(const Vector3d& x, const TriangleCorners& c)
{
    const Vector3d n = areaNormal(c);
    if (hasArea(c, n))
    {
        std::array<double, 3> weights{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Vector3d& p = c[(k + 1) % 3];
            weights[k] = (c[(k + 2) % 3] - p).cross(x - p).dot(n) / n.squaredNorm();
        }
        if (*std::min_element(weights.begin(), weights.end()) >= 0.0)
        {
            const double height = (x - c[0]).dot(n) / n.norm();
            return {.point = x - height * n.normalized(),
                    .weights = weights,
                    .distance = std::abs(height)};
        }
    }
    ClosestOnTriangle best{.distance = std::numeric_limits<double>::infinity()};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const std::size_t l = (k + 1) % 3;
        const Vector3d d = c[l] - c[k];
        const double squared = d.squaredNorm();
        const double s = squared > 0.0 ? std::clamp(d.dot(x - c[k]) / squared, 0.0, 1.0) : 0.0;
        // The ends exactly: a corner shared by several triangles is the same point for each.
        const Vector3d point = s >= 1.0 ? c[l] : Vector3d(c[k] + s * d);
        const double distance = (x - point).norm();
        if (distance < best.distance)
        {
            best = {.point = point, .weights = {}, .distance = distance};
            best.weights[k] = 1.0 - s;
            best.weights[l] = s;
        }
    }
    return best;
}

Vector3d unitNormal(const TriangleCorners& corners)
{
    const Vector3d n = areaNormal(corners);
    return hasArea(corners, n) ? Vector3d(n.stableNormalized()) : Vector3d::Zero();
}

NearSurface::NearSurface(const SsvTree& tree,
                         const Eigen::Isometry3d& X_FG,
                         std::vector<std::int32_t> triangles)
    : m_triangles(std::move(triangles))
{
    std::sort(m_triangles.begin(), m_triangles.end());
    m_triangles.erase(std::unique(m_triangles.begin(), m_triangles.end()), m_triangles.end());
    const auto merged = mergedVertices(tree.mesh(), m_triangles);
    for (std::size_t i = 0; i < m_triangles.size(); ++i)
    {
        TriangleCorners corners = tree.cornersOfTriangle(m_triangles[i]);
        Triangle vertices = tree.mesh().triangles[static_cast<std::size_t>(m_triangles[i])];
        for (std::size_t k = 0; k < 3; ++k)
        {
            corners[k] = X_FG * corners[k];
            vertices[k] =
                std::lower_bound(merged.begin(), merged.end(), std::pair(vertices[k], kNone))
                    ->second;
            m_around.emplace_back(vertices[k], i);
        }
        m_corners.push_back(corners);
        m_normals.push_back(unitNormal(corners));
        m_vertices.push_back(vertices);
    }
    std::sort(m_around.begin(), m_around.end());
    m_around.erase(std::unique(m_around.begin(), m_around.end()), m_around.end());
}

std::size_t NearSurface::indexOf(std::int32_t meshTriangle) const
{
    const auto at = std::lower_bound(m_triangles.begin(), m_triangles.end(), meshTriangle);
    BULLET_CCD_ASSERT(at != m_triangles.end() && *at == meshTriangle);
    return static_cast<std::size_t>(at - m_triangles.begin());
}

Feature NearSurface::feature(std::size_t i, const std::array<double, 3>& weights) const
{
    std::array<std::int32_t, 3> vertices{kNone, kNone, kNone};
    for (std::size_t k = 0; k < 3; ++k)
    {
        if (weights[k] > kOnBoundary)
        {
            vertices[k] = m_vertices[i][k];
        }
    }
    return featureOf(vertices);
}

std::vector<std::size_t> NearSurface::around(const Feature& feature) const
{
    std::vector<std::size_t> triangles;
    auto at = std::lower_bound(
        m_around.begin(), m_around.end(), std::pair(feature.vertices[0], std::size_t{0}));
    for (; at != m_around.end() && at->first == feature.vertices[0]; ++at)
    {
        const Triangle& vertices = m_vertices[at->second];
        if (std::all_of(feature.vertices.begin(),
                        feature.vertices.end(),
                        [&](std::int32_t v) { return v == kNone || has(vertices, v); }))
        {
            triangles.push_back(at->second);
        }
    }
    return triangles;
}

const Vector3d& NearSurface::corner(std::size_t i, std::int32_t vertex) const
{
    const auto at = std::find(m_vertices[i].begin(), m_vertices[i].end(), vertex);
    BULLET_CCD_ASSERT(at != m_vertices[i].end());
    return m_corners[i][static_cast<std::size_t>(at - m_vertices[i].begin())];
}

Vector3d NearSurface::edgeDirection(const Feature& feature) const
{
    if (feature.kind != FeatureKind::Edge)
    {
        return Vector3d::Zero();
    }
    const std::size_t i = around(feature).front();
    return (corner(i, feature.vertices[1]) - corner(i, feature.vertices[0])).stableNormalized();
}

Vector3d NearSurface::meanNormal(const Feature& feature) const
{
    Vector3d sum = Vector3d::Zero();
    for (const std::size_t i : around(feature))
    {
        double weight = 1.0;
        if (feature.kind == FeatureKind::Vertex)
        {
            // By the angle of the triangle there: the same however its faces are cut.
            const auto at =
                std::find(m_vertices[i].begin(), m_vertices[i].end(), feature.vertices[0]);
            const auto k = static_cast<std::size_t>(at - m_vertices[i].begin());
            const Vector3d u = m_corners[i][(k + 1) % 3] - m_corners[i][k];
            const Vector3d v = m_corners[i][(k + 2) % 3] - m_corners[i][k];
            weight = std::atan2(u.cross(v).norm(), u.dot(v));
        }
        sum += weight * m_normals[i];
    }
    return sum.norm() > kOnBoundary ? Vector3d(sum.normalized()) : Vector3d::Zero();
}

bool NearSurface::isFlat(const Feature& feature, double offPlane) const
{
    if (feature.kind != FeatureKind::Vertex)
    {
        return feature.kind == FeatureKind::Edge && isFlatEdge(feature, offPlane);
    }
    const std::int32_t vertex = feature.vertices[0];
    bool hasEdges = false;
    for (const std::size_t i : around(feature))
    {
        for (const std::int32_t other : m_vertices[i])
        {
            if (other != vertex && !isFlatEdge(featureOf({vertex, other, kNone}), offPlane))
            {
                return false;
            }
            hasEdges = hasEdges || other != vertex;
        }
    }
    return hasEdges;
}

bool NearSurface::isFlatEdge(const Feature& edge, double offPlane) const
{
    constexpr double kAngle = 1e-6;
    const std::vector<std::size_t> triangles = around(edge);
    const Vector3d& normal = m_normals[triangles.front()];
    bool left = false;
    bool right = false;
    for (const std::size_t i : triangles)
    {
        const Vector3d& start = corner(i, edge.vertices[0]);
        const Vector3d across =
            normal.cross(corner(i, edge.vertices[1]) - start).stableNormalized();
        double off = 0.0;
        double side = 0.0;
        for (const Vector3d& c : m_corners[i])
        {
            const double along = across.dot(c - start);
            off = std::max(off, std::abs(normal.dot(c - start)));
            side = std::abs(along) > std::abs(side) ? along : side;
        }
        // Triangles without area, or that stand up, are farther off than to the side.
        if (m_normals[i].isZero(0.0) || normal.isZero(0.0) || off > offPlane ||
            off > kAngle * std::abs(side))
        {
            return false;
        }
        left = left || side > 0.0;
        right = right || side < 0.0;
    }
    return left && right;
}
}  // namespace bullet_ccd
