#include "robots/shapes/remesh.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace bullet_ccd::shapes
{
namespace
{
constexpr int kRounds = 5;              // of collapse, flip and relax; later ones change little
constexpr int kProjectionSteps = 3;     // Newton steps on to the surface
constexpr double kOnSurface = 1e-8;     // [m]
constexpr double kFlat = 0.1;           // gradient that points nowhere; 1 on most surfaces
constexpr double kGrading = 0.3;        // growth of the wanted edge length per length
constexpr double kCollapseBelow = 0.8;  // of the wanted length
constexpr double kLongestAfter = 1.35;  // of the wanted length
constexpr double kLeastCosine = 0.5;    // between a triangle and the surface under it
constexpr double kLeastShape = 0.05;    // area over squared longest edge; equilateral: 0.43
constexpr double kGoodShape = 0.25;     // needs no improvement

using Edge = std::pair<std::int32_t, std::int32_t>;

class Remesher
{
public:
    Remesher(const TriangleMesh& mesh, const Solid& solid, const PolygonizeOptions& options)
        : m_solid(solid),
          m_options(options),
          m_points(mesh.vertices),
          m_triangles(mesh.triangles),
          m_alive(mesh.triangles.size(), true),
          m_trianglesAt(mesh.vertices.size())
    {
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            for (const std::int32_t v : m_triangles[t])
            {
                around(v).push_back(static_cast<std::int32_t>(t));
            }
        }
        m_normals.resize(m_points.size());
        for (std::size_t v = 0; v < m_points.size(); ++v)
        {
            place(static_cast<std::int32_t>(v), mesh.vertices[v]);
        }
        computeSizes();
    }

    TriangleMesh run()
    {
        for (int round = 0; round < kRounds; ++round)
        {
            while (collapseShortEdges() > m_points.size() / 200)
            {
            }
            flipEdges();
            relax();
        }
        collapseShortEdges();
        flipEdges();
        removeSlivers();
        TriangleMesh result;
        result.vertices = m_points;
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            if (m_alive[t])
            {
                result.triangles.push_back(m_triangles[t]);
            }
        }
        repairMesh(result);
        return result;
    }

private:
    [[nodiscard]] std::vector<std::int32_t>& around(std::int32_t v)
    {
        return m_trianglesAt[static_cast<std::size_t>(v)];
    }
    [[nodiscard]] const Eigen::Vector3d& point(std::int32_t v) const
    {
        return m_points[static_cast<std::size_t>(v)];
    }
    [[nodiscard]] const Triangle& triangle(std::int32_t t) const
    {
        return m_triangles[static_cast<std::size_t>(t)];
    }
    [[nodiscard]] double length(const Edge& e) const
    {
        return (point(e.first) - point(e.second)).norm();
    }
    [[nodiscard]] double wantedLength(const Edge& e) const
    {
        return std::min(m_sizes[static_cast<std::size_t>(e.first)],
                        m_sizes[static_cast<std::size_t>(e.second)]);
    }

    /// Moves the vertex on to the surface by Newton steps along the gradient; it starts closer to
    /// the surface than any fillet radius. Its normal is the last gradient on the way.
    void place(std::int32_t v, const Eigen::Vector3d& start)
    {
        Eigen::Vector3d& p = m_points[static_cast<std::size_t>(v)];
        Eigen::Vector3d& normal = m_normals[static_cast<std::size_t>(v)];
        p = start;
        double value = m_solid(p);
        for (int i = 0; i < kProjectionSteps && (i == 0 || std::abs(value) > kOnSurface); ++i)
        {
            const Eigen::Vector3d gradient = gradientAt(m_solid, p);
            if (gradient.squaredNorm() < kFlat * kFlat)
            {
                break;  // in the middle of a wall, where the function has no direction
            }
            p -= value / gradient.squaredNorm() * gradient;
            normal = gradient.normalized();
            value = m_solid(p);
        }
    }

    /// Neighbours of a vertex, sorted.
    [[nodiscard]] std::vector<std::int32_t> neighbours(std::int32_t v)
    {
        std::vector<std::int32_t> result;
        for (const std::int32_t t : around(v))
        {
            for (const std::int32_t other : triangle(t))
            {
                if (other != v)
                {
                    result.push_back(other);
                }
            }
        }
        std::ranges::sort(result);
        result.erase(std::ranges::unique(result).begin(), result.end());
        return result;
    }

    [[nodiscard]] bool areNeighbours(std::int32_t a, std::int32_t b)
    {
        return std::ranges::any_of(
            around(a),
            [&](std::int32_t t) { return std::ranges::find(triangle(t), b) != triangle(t).end(); });
    }

    [[nodiscard]] std::vector<Edge> edges() const
    {
        std::vector<Edge> result;
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            for (std::size_t i = 0; m_alive[t] && i < 3; ++i)
            {
                const Edge edge(m_triangles[t][i], m_triangles[t][(i + 1) % 3]);
                if (edge.first < edge.second)
                {
                    result.push_back(edge);  // the other triangle has it the other way round
                }
            }
        }
        return result;
    }

    /// Wanted edge lengths from curvature: a chord of length L over radius r is off by L² / (8 r).
    void computeSizes()
    {
        const std::vector<Edge> all = edges();
        std::vector<double> curvature(m_points.size(), 0.0);
        for (const Edge& e : all)
        {
            const auto i = static_cast<std::size_t>(e.first);
            const auto j = static_cast<std::size_t>(e.second);
            const double turn = (m_normals[i] - m_normals[j]).norm();
            // Slivers of the grid: the turn over a tiny length is noise.
            const double k = turn / std::max(length(e), 0.25 * m_options.cell);
            curvature[i] = std::max(curvature[i], k);
            curvature[j] = std::max(curvature[j], k);
        }
        for (const double k : curvature)
        {
            const double size = std::sqrt(8.0 * m_options.chordError / std::max(k, 1e-9));
            m_sizes.push_back(std::clamp(size, m_options.shortestEdge, m_options.longestEdge));
        }
        for (int sweep = 0; sweep < 12; ++sweep)
        {
            for (const Edge& e : all)
            {
                double& a = m_sizes[static_cast<std::size_t>(e.first)];
                double& b = m_sizes[static_cast<std::size_t>(e.second)];
                a = std::min(a, b + kGrading * length(e));
                b = std::min(b, a + kGrading * length(e));
            }
        }
    }

    /// Area over squared longest edge; negative if the triangle is turned off the surface.
    [[nodiscard]] static double quality(const std::array<Eigen::Vector3d, 3>& p,
                                        const Eigen::Vector3d& surfaceNormal)
    {
        const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
        const double longest = std::max({(p[1] - p[0]).squaredNorm(),
                                         (p[2] - p[1]).squaredNorm(),
                                         (p[0] - p[2]).squaredNorm()});
        const double shape = 0.5 * normal.norm() / longest;
        const bool isTurned =
            !(normal.dot(surfaceNormal) > kLeastCosine * normal.norm() * surfaceNormal.norm());
        return isTurned ? -1.0 : shape;
    }

    [[nodiscard]] double qualityOf(const Triangle& t) const
    {
        const Eigen::Vector3d normals = m_normals[static_cast<std::size_t>(t[0])] +
                                        m_normals[static_cast<std::size_t>(t[1])] +
                                        m_normals[static_cast<std::size_t>(t[2])];
        return quality({point(t[0]), point(t[1]), point(t[2])}, normals);
    }

    [[nodiscard]] double worstAround(std::int32_t v)
    {
        double worst = std::numeric_limits<double>::infinity();
        for (const std::int32_t t : around(v))
        {
            worst = std::min(worst, qualityOf(triangle(t)));
        }
        return worst;
    }

    /// Worst quality of the triangles around `v`, less those that contain `except`, with v at `p`.
    [[nodiscard]] double worstAround(std::int32_t v,
                                     std::int32_t except,
                                     const Eigen::Vector3d& p,
                                     const Eigen::Vector3d& normal)
    {
        double worst = std::numeric_limits<double>::infinity();
        for (const std::int32_t t : around(v))
        {
            if (std::ranges::find(triangle(t), except) != triangle(t).end())
            {
                continue;
            }
            std::array<Eigen::Vector3d, 3> corners;
            Eigen::Vector3d normals = normal;
            for (std::size_t i = 0; i < 3; ++i)
            {
                const std::int32_t corner = triangle(t)[i];
                corners[i] = corner == v ? p : point(corner);
                if (corner != v)
                {
                    normals += m_normals[static_cast<std::size_t>(corner)];
                }
            }
            worst = std::min(worst, quality(corners, normals));
        }
        return worst;
    }

    std::size_t collapseShortEdges()
    {
        std::vector<std::pair<double, Edge>> queue;
        for (const Edge& e : edges())
        {
            const double share = length(e) / wantedLength(e);
            if (share < kCollapseBelow)
            {
                queue.emplace_back(share, e);
            }
        }
        std::ranges::sort(queue);
        std::size_t collapsed = 0;
        for (const auto& [share, e] : queue)
        {
            collapsed += tryCollapse(e) ? 1 : 0;
        }
        return collapsed;
    }

    /// Merges the ends of an edge into its middle on the surface, unless that would change the
    /// topology (the ends share a neighbour beyond the two opposite corners), make a long edge or
    /// a bad triangle.
    /// @param whateverLength  collapses edges that are as long as wanted, too
    bool tryCollapse(const Edge& e, bool whateverLength = false)
    {
        const auto [keep, drop] = e;
        if (!whateverLength && length(e) >= kCollapseBelow * wantedLength(e))
        {
            return false;
        }
        const std::vector<std::int32_t> a = neighbours(keep);
        const std::vector<std::int32_t> b = neighbours(drop);
        std::vector<std::int32_t> shared;
        std::ranges::set_intersection(a, b, std::back_inserter(shared));
        if (!std::ranges::binary_search(a, drop) || shared.size() != 2 || a.size() + b.size() < 8)
        {
            return false;
        }
        const Eigen::Vector3d middle = 0.5 * (point(keep) + point(drop));
        const double size = wantedLength(e);
        if (!whateverLength &&
            (makesLongEdge(a, e, middle, size) || makesLongEdge(b, e, middle, size)))
        {
            return false;
        }
        const Eigen::Vector3d normal =
            (m_normals[static_cast<std::size_t>(keep)] + m_normals[static_cast<std::size_t>(drop)])
                .normalized();
        const double allowed =
            std::min(kLeastShape, 0.8 * std::min(worstAround(keep), worstAround(drop)));
        if (worstAround(keep, drop, middle, normal) < allowed ||
            worstAround(drop, keep, middle, normal) < allowed)
        {
            return false;
        }
        merge(keep, drop);
        place(keep, middle);
        m_sizes[static_cast<std::size_t>(keep)] = size;
        return true;
    }

    [[nodiscard]] bool makesLongEdge(const std::vector<std::int32_t>& ring,
                                     const Edge& collapsing,
                                     const Eigen::Vector3d& middle,
                                     double size) const
    {
        return std::ranges::any_of(ring,
                                   [&](std::int32_t v)
                                   {
                                       const double limit =
                                           kLongestAfter *
                                           std::min(size, m_sizes[static_cast<std::size_t>(v)]);
                                       return v != collapsing.first && v != collapsing.second &&
                                              (point(v) - middle).squaredNorm() > limit * limit;
                                   });
    }

    void merge(std::int32_t keep, std::int32_t drop)
    {
        const std::vector<std::int32_t> moved = std::exchange(around(drop), {});
        for (const std::int32_t t : moved)
        {
            Triangle& corners = m_triangles[static_cast<std::size_t>(t)];
            if (std::ranges::find(corners, keep) == corners.end())
            {
                std::ranges::replace(corners, drop, keep);
                around(keep).push_back(t);
                continue;
            }
            m_alive[static_cast<std::size_t>(t)] = false;
            for (const std::int32_t v : corners)
            {
                std::erase(around(v), t);
            }
        }
    }

    /// What the rules for edge lengths left over: collapses the shortest edge of bad triangles.
    void removeSlivers()
    {
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            if (!m_alive[t] || qualityOf(m_triangles[t]) >= kLeastShape)
            {
                continue;
            }
            const Triangle corners = m_triangles[t];
            std::array<Edge, 3> sides = {Edge(std::minmax(corners[0], corners[1])),
                                         Edge(std::minmax(corners[1], corners[2])),
                                         Edge(std::minmax(corners[2], corners[0]))};
            std::ranges::sort(sides, {}, [&](const Edge& e) { return length(e); });
            static_cast<void>(tryCollapse(sides[0], true) || tryCollapse(sides[1], true));
        }
    }

    /// Turns edges of two triangles where that makes the worse of the two better.
    void flipEdges()
    {
        for (int sweep = 0; sweep < 3; ++sweep)
        {
            for (const Edge& e : edges())
            {
                tryFlip(e);
            }
        }
    }

    void tryFlip(const Edge& e)
    {
        std::int32_t left = kNone;
        std::int32_t right = kNone;
        std::int32_t c = kNone;
        std::int32_t d = kNone;
        for (const std::int32_t t : around(e.first))
        {
            for (std::size_t i = 0; i < 3; ++i)
            {
                const std::int32_t from = triangle(t)[i];
                const std::int32_t to = triangle(t)[(i + 1) % 3];
                if (from == e.first && to == e.second)
                {
                    left = t;
                    c = triangle(t)[(i + 2) % 3];
                }
                if (from == e.second && to == e.first)
                {
                    right = t;
                    d = triangle(t)[(i + 2) % 3];
                }
            }
        }
        if (left == kNone || right == kNone || c == d || around(e.first).size() < 5 ||
            around(e.second).size() < 5)
        {
            return;
        }
        const Triangle newLeft = {e.first, d, c};
        const Triangle newRight = {d, e.second, c};
        const double before = std::min(qualityOf(triangle(left)), qualityOf(triangle(right)));
        const double after = std::min(qualityOf(newLeft), qualityOf(newRight));
        if (after <= std::max(0.0, 1.05 * before) || areNeighbours(c, d))
        {
            return;
        }
        m_triangles[static_cast<std::size_t>(left)] = newLeft;
        m_triangles[static_cast<std::size_t>(right)] = newRight;
        std::erase(around(e.second), left);
        std::erase(around(e.first), right);
        around(d).push_back(left);
        around(c).push_back(right);
    }

    /// Slides every vertex towards the middle of its neighbours where that keeps shapes good.
    void relax()
    {
        for (std::int32_t v = 0; v < static_cast<std::int32_t>(m_points.size()); ++v)
        {
            if (around(v).empty())
            {
                continue;
            }
            const std::vector<std::int32_t> ring = neighbours(v);
            Eigen::Vector3d middle = Eigen::Vector3d::Zero();
            for (const std::int32_t other : ring)
            {
                middle += point(other) / static_cast<double>(ring.size());
            }
            const Eigen::Vector3d oldPoint = point(v);
            const Eigen::Vector3d oldNormal = m_normals[static_cast<std::size_t>(v)];
            const double before = worstAround(v);
            const Eigen::Vector3d step = 0.7 * (middle - oldPoint);
            place(v, oldPoint + step - step.dot(oldNormal) * oldNormal);
            if (worstAround(v) < std::min(before, kGoodShape))
            {
                m_points[static_cast<std::size_t>(v)] = oldPoint;
                m_normals[static_cast<std::size_t>(v)] = oldNormal;
            }
        }
    }

    const Solid& m_solid;
    PolygonizeOptions m_options;
    std::vector<Eigen::Vector3d> m_points;
    std::vector<Eigen::Vector3d> m_normals;
    std::vector<double> m_sizes;  ///< wanted edge length at each vertex
    std::vector<Triangle> m_triangles;
    std::vector<bool> m_alive;
    std::vector<std::vector<std::int32_t>> m_trianglesAt;
};
}  // namespace

TriangleMesh remesh(const TriangleMesh& mesh, const Solid& solid, const PolygonizeOptions& options)
{
    return Remesher(mesh, solid, options).run();
}
}  // namespace bullet_ccd::shapes
