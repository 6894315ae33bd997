#include "bullet_ccd/reduce/collapse_edges.h"

#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/reduce/nearest_triangle.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

using Index = std::int32_t;

constexpr double kLeastTurn = 0.2;      // cosine, of a triangle by a collapse
constexpr double kThinnest = 1e-3;      // height of a triangle over its longest edge
constexpr double kBorderWeight = 1.0;   // of the plane on a border, over that of a triangle
constexpr double kLengthWeight = 1e-6;  // of an edge's square, where the surface is flat
constexpr double kNear = 0.25;          // of the tolerance: a triangle so near is near enough
constexpr int kCollapsesBetweenLooks = 64;

/// Sum of squared distances from planes, weighted by areas (Garland and Heckbert 1997).
struct Quadric
{
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    double c = 0.0;

    void addPlane(const Vector3d& normal, const Vector3d& point, double weight)
    {
        const double offset = normal.dot(point);
        a += weight * normal * normal.transpose();
        b -= weight * offset * normal;
        c += weight * offset * offset;
    }
    void add(const Quadric& other)
    {
        a += other.a;
        b += other.b;
        c += other.c;
    }
    [[nodiscard]] double at(const Vector3d& x) const { return x.dot(a * x) + 2.0 * b.dot(x) + c; }
    /// The point of least value that is nearest to `x`: directions in which the value hardly
    /// changes are left alone.
    [[nodiscard]] Vector3d lowestNear(const Vector3d& x) const
    {
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
        solver.computeDirect(a);
        const Vector3d down = -(a * x + b);
        Vector3d step = Vector3d::Zero();
        constexpr double kFlat = 1e-3;
        for (int k = 0; k < 3; ++k)
        {
            const double value = solver.eigenvalues()[k];
            if (value > kFlat * solver.eigenvalues()[2])
            {
                const Vector3d axis = solver.eigenvectors().col(k);
                step += down.dot(axis) / value * axis;
            }
        }
        return x + step;
    }
};

struct Edge
{
    double cost;
    Index a;
    Index b;
    Index stamp;  // of both ends when it was put in the queue: their sum

    bool operator<(const Edge& other) const  // the cheapest is the top of a queue
    {
        return std::tie(other.cost, other.a, other.b) < std::tie(cost, a, b);
    }
};

class Collapser
{
public:
    Collapser(const TriangleMesh& start,
              const SsvTree& full,
              double tolerance,
              const StopCondition& stop)
        : m_full(full),
          m_tolerance(tolerance),
          m_stop(stop),
          m_triangles(start.triangles),
          m_isGone(m_triangles.size(), false),
          m_witnesses(m_triangles.size())
    {
        for (const Vector3d& vertex : start.vertices)
        {
            m_points.emplace_back(vertex - full.origin());
        }
        m_stars.resize(m_points.size());
        m_stamps.resize(m_points.size());
        m_quadrics.resize(m_points.size());
        m_isBorder.resize(m_points.size());
        m_isLocked.resize(m_points.size());
        m_guesses.assign(m_points.size(), kNone);
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            for (const Index v : m_triangles[t])
            {
                star(v).push_back(Index(t));
            }
        }
        weighPlanes();
        addWitnesses(start);
    }

    TriangleMesh run()
    {
        for (Index v = 0; v < Index(m_points.size()); ++v)
        {
            offerEdges(v, true);
        }
        for (int done = 0; !m_queue.empty(); ++done)
        {
            if (done % kCollapsesBetweenLooks == 0 && m_stop.isDue())
            {
                throw QueryStopped("reduce: the search was stopped before its end");
            }
            const Edge edge = m_queue.top();
            m_queue.pop();
            if (edge.stamp == m_stamps[at(edge.a)] + m_stamps[at(edge.b)] &&
                !star(edge.a).empty() && !star(edge.b).empty())
            {
                collapse(edge.a, edge.b);
            }
        }
        TriangleMesh result;
        result.vertices = m_points;
        for (Vector3d& vertex : result.vertices)
        {
            vertex += m_full.origin();
        }
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            if (!m_isGone[t])
            {
                result.triangles.push_back(m_triangles[t]);
            }
        }
        repairMesh(result);
        return result;
    }

private:
    static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
    std::vector<Index>& star(Index v) { return m_stars[at(v)]; }
    /// Vertices, middles of edges and of triangles of the full mesh.
    void addWitnesses(const TriangleMesh& start)
    {
        const TriangleMesh& mesh = m_full.mesh();
        const auto point = [&](Index v) -> Vector3d
        { return mesh.vertices[at(v)] - m_full.origin(); };
        for (Index v = 0; v < Index(mesh.vertices.size()); ++v)
        {
            m_originals.push_back(point(v));
        }
        for (const Triangle& t : mesh.triangles)
        {
            m_originals.emplace_back((point(t[0]) + point(t[1]) + point(t[2])) / 3.0);
            for (std::size_t k = 0; k < 3; ++k)
            {
                const Index a = t[k];
                const Index b = t[(k + 1) % 3];
                if (a < b)
                {
                    m_originals.emplace_back(0.5 * (point(a) + point(b)));
                }
            }
        }
        const SsvTree tree = buildSsvTree(start);
        std::int32_t near = kNone;
        for (std::size_t i = 0; i < m_originals.size(); ++i)
        {
            near =
                nearestTriangle(tree, m_originals[i] + m_full.origin() - tree.origin(), near).slot;
            m_witnesses[at(tree.triangle(near))].push_back(Index(i));
        }
    }
    [[nodiscard]] TriangleCorners corners(const Triangle& t) const
    {
        return {m_points[at(t[0])], m_points[at(t[1])], m_points[at(t[2])]};
    }

    void weighPlanes()
    {
        for (std::size_t t = 0; t < m_triangles.size(); ++t)
        {
            const auto [p, q, r] = corners(m_triangles[t]);
            const Vector3d normal = (q - p).cross(r - p);
            const double area = normal.norm();
            for (const Index v : m_triangles[t])
            {
                m_quadrics[at(v)].addPlane(normal.stableNormalized(), p, area);
            }
            for (std::size_t k = 0; k < 3; ++k)
            {
                const Index a = m_triangles[t][k];
                const Index b = m_triangles[t][(k + 1) % 3];
                const auto count = std::ranges::count_if(
                    star(a), [&](Index other) { return has(m_triangles[at(other)], b); });
                if (count == 2)
                {
                    continue;
                }
                const Vector3d edge = m_points[at(b)] - m_points[at(a)];
                for (const Index v : {a, b})
                {
                    m_quadrics[at(v)].addPlane(edge.cross(normal).stableNormalized(),
                                               m_points[at(a)],
                                               kBorderWeight * edge.squaredNorm());
                    m_isBorder[at(v)] = true;
                    m_isLocked[at(v)] = m_isLocked[at(v)] || count > 2;
                }
            }
        }
    }

    static bool has(const Triangle& t, Index v) { return std::ranges::find(t, v) != t.end(); }

    std::vector<Index> neighbours(Index v)
    {
        std::vector<Index> result;
        for (const Index t : star(v))
        {
            for (const Index other : m_triangles[at(t)])
            {
                if (other != v)
                {
                    result.push_back(other);
                }
            }
        }
        std::ranges::sort(result);
        result.erase(std::unique(result.begin(), result.end()), result.end());
        return result;
    }

    void offerEdges(Index v, bool onlyLater)
    {
        for (const Index other : neighbours(v))
        {
            if (!onlyLater || other > v)
            {
                const Index a = std::min(v, other);
                const Index b = std::max(v, other);
                m_queue.push({.cost = places(a, b).front().first,
                              .a = a,
                              .b = b,
                              .stamp = m_stamps[at(a)] + m_stamps[at(b)]});
            }
        }
    }

    /// A cost, and where the vertex may come that both ends of an edge become.
    using Place = std::pair<double, Vector3d>;

    /// The cheapest first.
    std::array<Place, 2> places(Index a, Index b)
    {
        Quadric sum = m_quadrics[at(a)];
        sum.add(m_quadrics[at(b)]);
        const Vector3d& p = m_points[at(a)];
        const Vector3d& q = m_points[at(b)];
        const double length = kLengthWeight * (p - q).squaredNorm() * (p - q).squaredNorm();
        const auto place = [&](const Vector3d& x) -> Place {
            return {std::max(0.0, sum.at(x)) + length, x};
        };
        const std::array<Place, 2> ends{place(p), place(q)};
        std::array<Place, 2> result{place(sum.lowestNear(0.5 * (p + q))),
                                    ends[ends[1].first < ends[0].first ? 1 : 0]};
        if (result[1].first < result[0].first)
        {
            std::swap(result[0], result[1]);
        }
        return result;
    }

    void collapse(Index a, Index b)
    {
        if (m_isLocked[at(a)] || m_isLocked[at(b)])
        {
            return;
        }
        std::vector<Index> around;  // triangles that stay
        std::vector<Index> between;
        for (const Index t : star(a))
        {
            (has(m_triangles[at(t)], b) ? between : around).push_back(t);
        }
        for (const Index t : star(b))
        {
            if (!has(m_triangles[at(t)], a))
            {
                around.push_back(t);
            }
        }
        // The surface keeps its topology if the ends have no other neighbours in common than those
        // of the triangles between them.
        const std::vector<Index> ofA = neighbours(a);
        const std::vector<Index> ofB = neighbours(b);
        std::vector<Index> common;
        std::ranges::set_intersection(ofA, ofB, std::back_inserter(common));
        const bool bothBorder = m_isBorder[at(a)] && m_isBorder[at(b)];
        if (around.empty() || common.size() != between.size() ||
            (bothBorder && between.size() != 1) || ofA.size() + ofB.size() < 6)
        {
            return;
        }
        std::vector<Index> witnesses;
        for (const std::vector<Index>* list : {&around, &between})
        {
            for (const Index t : *list)
            {
                witnesses.insert(
                    witnesses.end(), m_witnesses[at(t)].begin(), m_witnesses[at(t)].end());
            }
        }
        for (const auto& [cost, place] : places(a, b))
        {
            if (mayMove(a, b, place, around, witnesses))
            {
                move(a, b, place, around, between, witnesses);
                return;
            }
        }
    }

    [[nodiscard]] TriangleCorners moved(Index t, Index a, Index b, const Vector3d& place) const
    {
        TriangleCorners result = corners(m_triangles[at(t)]);
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Index v = m_triangles[at(t)][k];
            result[k] = v == a || v == b ? place : result[k];
        }
        return result;
    }

    /// Also finds a triangle near to each witness.
    bool mayMove(Index a,
                 Index b,
                 const Vector3d& place,
                 const std::vector<Index>& around,
                 const std::vector<Index>& witnesses)
    {
        m_moved.clear();
        for (const Index t : around)
        {
            m_moved.push_back(moved(t, a, b, place));
            const auto& [p, q, r] = m_moved.back();
            const auto [p0, q0, r0] = corners(m_triangles[at(t)]);
            const Vector3d normal = (q - p).cross(r - p);
            const Vector3d before = (q0 - p0).cross(r0 - p0);
            const double longest =
                std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
            if (!(normal.norm() > kThinnest * longest) ||
                normal.dot(before) < kLeastTurn * normal.norm() * before.norm())
            {
                return false;
            }
        }
        m_nearest.clear();
        std::size_t guess = 0;
        for (const Index witness : witnesses)
        {
            const Vector3d& point = m_originals[at(witness)];
            double least = pointToTriangle(point, m_moved[guess]).distance;
            for (std::size_t k = 0; k < m_moved.size() && least > kNear * m_tolerance; ++k)
            {
                const double distance = pointToTriangle(point, m_moved[k]).distance;
                if (distance < least)
                {
                    least = distance;
                    guess = k;
                }
            }
            if (least > m_tolerance)
            {
                return false;
            }
            m_nearest.push_back(guess);
        }
        std::int32_t& near = m_guesses[at(a)];
        const auto isNear = [&](const TriangleCorners& t)
        {
            return triangleDeviation(t, m_full, m_tolerance, m_tolerance, m_stop, near).upper <=
                   m_tolerance;
        };
        return std::ranges::all_of(m_moved, isNear);
    }

    /// B becomes A, at `place`.
    void move(Index a,
              Index b,
              const Vector3d& place,
              const std::vector<Index>& around,
              const std::vector<Index>& between,
              const std::vector<Index>& witnesses)
    {
        m_points[at(a)] = place;
        m_quadrics[at(a)].add(m_quadrics[at(b)]);
        m_isBorder[at(a)] = m_isBorder[at(a)] || m_isBorder[at(b)];
        for (const Index t : between)
        {
            m_isGone[at(t)] = true;
            m_witnesses[at(t)].clear();
            for (const Index v : m_triangles[at(t)])
            {
                std::erase(star(v), t);
            }
        }
        for (const Index t : around)
        {
            std::ranges::replace(m_triangles[at(t)], b, a);
            m_witnesses[at(t)].clear();
        }
        star(a) = around;
        star(b).clear();
        for (std::size_t k = 0; k < witnesses.size(); ++k)
        {
            m_witnesses[at(around[m_nearest[k]])].push_back(witnesses[k]);
        }
        ++m_stamps[at(a)];
        offerEdges(a, false);
    }

    const SsvTree& m_full;
    double m_tolerance;
    const StopCondition& m_stop;
    std::vector<Triangle> m_triangles;
    std::vector<bool> m_isGone;
    std::vector<std::vector<Index>> m_witnesses;  // of each triangle: points of the full mesh
    std::vector<Vector3d> m_points;               // full's frame
    std::vector<Vector3d> m_originals;            // what witnesses are
    std::vector<std::vector<Index>> m_stars;      // triangles about each vertex
    std::vector<Index> m_stamps;
    std::vector<Quadric> m_quadrics;
    std::vector<bool> m_isBorder;
    std::vector<bool> m_isLocked;
    std::vector<std::int32_t> m_guesses;  // slots of the full mesh
    std::priority_queue<Edge> m_queue;
    std::vector<TriangleCorners> m_moved;
    std::vector<std::size_t> m_nearest;
};
}  // namespace

TriangleMesh collapseEdges(const TriangleMesh& start,
                           const SsvTree& full,
                           double tolerance,
                           const StopCondition& stop)
{
    return Collapser(start, full, tolerance, stop).run();
}
}  // namespace bullet_ccd
