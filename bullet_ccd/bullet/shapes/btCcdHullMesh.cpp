#include "bullet_ccd/bullet/shapes/btCcdHullMesh.h"

#include "bullet_ccd/math/check.h"

#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

using bullet_ccd::Triangle;
using bullet_ccd::TriangleMesh;

namespace
{
using Points = std::vector<Eigen::Vector3d>;

/// Of the size: what separates a point from a plane.
constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
/// Of the size: how far a point may end up outside before the result is not trusted.
constexpr double kOutside = 1e-9;

template <typename Measure>
std::int32_t largest(const Points& points, Measure&& measure)
{
    const auto found = std::max_element(points.begin(),
                                        points.end(),
                                        [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b)
                                        { return measure(a) < measure(b); });
    return std::int32_t(found - points.begin());
}

/// The mesh without the vertices that it does not use.
TriangleMesh compact(const Points& points, const std::vector<Triangle>& triangles)
{
    TriangleMesh mesh;
    std::unordered_map<std::int32_t, std::int32_t> renumbered;
    for (Triangle triangle : triangles)
    {
        for (std::int32_t& corner : triangle)
        {
            const auto [known, isNew] =
                renumbered.try_emplace(corner, std::int32_t(mesh.vertices.size()));
            if (isNew)
            {
                mesh.vertices.push_back(points[std::size_t(corner)]);
            }
            corner = known->second;
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

/// Hull of points in a plane, by increasing x then y in the plane (monotone chains), as a fan.
TriangleMesh flatHull(const Points& points, const Eigen::Vector3d& x, const Eigen::Vector3d& y)
{
    struct Placed
    {
        double x;
        double y;
        std::int32_t index;
    };
    std::vector<Placed> placed;
    for (const Eigen::Vector3d& point : points)
    {
        placed.push_back({x.dot(point), y.dot(point), std::int32_t(placed.size())});
    }
    std::sort(placed.begin(),
              placed.end(),
              [](const Placed& a, const Placed& b)
              { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
    std::vector<Placed> chain;
    const auto extend = [&](const Placed& next, std::size_t first)
    {
        const auto turnsRight = [&]
        {
            const Placed& a = chain[chain.size() - 2];
            const Placed& b = chain.back();
            return (b.x - a.x) * (next.y - a.y) <= (b.y - a.y) * (next.x - a.x);
        };
        while (chain.size() >= first + 2 && turnsRight())
        {
            chain.pop_back();
        }
        chain.push_back(next);
    };
    for (const Placed& next : placed)
    {
        extend(next, 0);
    }
    const std::size_t upper = chain.size() - 1;
    for (auto next = placed.rbegin() + 1; next != placed.rend(); ++next)
    {
        extend(*next, upper);
    }
    std::vector<Triangle> fan;
    for (std::size_t k = 1; k + 2 < chain.size(); ++k)  // the last is the first
    {
        fan.push_back({chain[0].index, chain[k].index, chain[k + 1].index});
    }
    return compact(points, fan);
}

/// Quickhull: every face keeps the points outside of it; the farthest of them replaces all faces
/// that it sees by a cone over their rim. A face whose plane holds the point counts as seen, so
/// that coplanar points make no slivers.
class Quickhull
{
public:
    Quickhull(const Points& points, double size) : m_points(points), m_epsilon(kRounding * size) {}

    std::vector<Triangle> run(Triangle base, std::int32_t apex);

private:
    struct Face
    {
        Triangle m_corners;
        Eigen::Vector3d m_normal;  // unit, outwards; zero without area
        std::vector<std::int32_t> m_outside;
        bool m_removed;
    };

    const Points& m_points;
    double m_epsilon;
    std::vector<Face> m_faces;
    std::unordered_map<std::uint64_t, std::int32_t> m_faceOfEdge;

    static std::uint64_t edge(std::int32_t from, std::int32_t to)
    {
        return (std::uint64_t(std::uint32_t(from)) << 32U) | std::uint32_t(to);
    }
    double height(const Face& face, std::int32_t point) const
    {
        return face.m_normal.dot(m_points[std::size_t(point)] -
                                 m_points[std::size_t(face.m_corners[0])]);
    }
    void addFace(const Triangle& corners);
    void sort(const std::vector<std::int32_t>& points, std::size_t firstFace);
    void addPoint(std::int32_t face, std::int32_t point);
};

void Quickhull::addFace(const Triangle& corners)
{
    const Eigen::Vector3d& a = m_points[std::size_t(corners[0])];
    const Eigen::Vector3d& b = m_points[std::size_t(corners[1])];
    const Eigen::Vector3d& c = m_points[std::size_t(corners[2])];
    for (std::size_t k = 0; k < 3; ++k)
    {
        m_faceOfEdge[edge(corners[k], corners[(k + 1) % 3])] = std::int32_t(m_faces.size());
    }
    m_faces.push_back({corners, (b - a).cross(c - a).normalized(), {}, false});
}

/// Gives the points to the first of the faces that they are outside of.
void Quickhull::sort(const std::vector<std::int32_t>& points, std::size_t firstFace)
{
    for (const std::int32_t point : points)
    {
        const auto face = std::find_if(m_faces.begin() + std::ptrdiff_t(firstFace),
                                       m_faces.end(),
                                       [&](const Face& candidate)
                                       { return height(candidate, point) > m_epsilon; });
        if (face != m_faces.end())
        {
            face->m_outside.push_back(point);
        }
    }
}

void Quickhull::addPoint(std::int32_t face, std::int32_t point)
{
    std::vector<std::int32_t> seen{face};
    std::vector<std::int32_t> orphans;
    std::vector<std::pair<std::int32_t, std::int32_t>> rim;
    m_faces[std::size_t(face)].m_removed = true;
    for (std::size_t k = 0; k < seen.size(); ++k)
    {
        const Triangle corners = m_faces[std::size_t(seen[k])].m_corners;
        for (std::size_t i = 0; i < 3; ++i)
        {
            const std::int32_t from = corners[i];
            const std::int32_t to = corners[(i + 1) % 3];
            const std::int32_t neighbour = m_faceOfEdge.at(edge(to, from));
            Face& beyond = m_faces[std::size_t(neighbour)];
            if (!beyond.m_removed && height(beyond, point) >= -m_epsilon)
            {
                beyond.m_removed = true;
                seen.push_back(neighbour);
            }
        }
    }
    for (const std::int32_t index : seen)
    {
        Face& gone = m_faces[std::size_t(index)];
        for (std::size_t i = 0; i < 3; ++i)
        {
            const std::int32_t from = gone.m_corners[i];
            const std::int32_t to = gone.m_corners[(i + 1) % 3];
            if (!m_faces[std::size_t(m_faceOfEdge.at(edge(to, from)))].m_removed)
            {
                rim.emplace_back(from, to);
            }
        }
        orphans.insert(orphans.end(), gone.m_outside.begin(), gone.m_outside.end());
        gone.m_outside = {};
    }
    const std::size_t firstNew = m_faces.size();
    for (const auto& [from, to] : rim)
    {
        addFace({from, to, point});
    }
    std::erase(orphans, point);
    sort(orphans, firstNew);
}

std::vector<Triangle> Quickhull::run(Triangle base, std::int32_t apex)
{
    addFace(base);
    if (height(m_faces[0], apex) > 0.0)
    {
        std::swap(base[1], base[2]);
        m_faces.clear();
        m_faceOfEdge.clear();
        addFace(base);
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
        addFace({base[(k + 1) % 3], base[k], apex});
    }
    std::vector<std::int32_t> all(m_points.size());
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        all[i] = std::int32_t(i);
    }
    sort(all, 0);
    // New faces come after the one that is looked at.
    for (std::size_t i = 0; i < m_faces.size(); ++i)
    {
        const std::vector<std::int32_t>& outside = m_faces[i].m_outside;
        if (!outside.empty())
        {
            const auto farthest =
                std::max_element(outside.begin(),
                                 outside.end(),
                                 [&](std::int32_t a, std::int32_t b)
                                 { return height(m_faces[i], a) < height(m_faces[i], b); });
            addPoint(std::int32_t(i), *farthest);
        }
    }
    std::vector<Triangle> triangles;
    for (const Face& face : m_faces)
    {
        if (!face.m_removed)
        {
            triangles.push_back(face.m_corners);
        }
    }
    return triangles;
}

/// Whether the hull is closed and all points (a sample of very many) are inside. Heights above the
/// plane of a face are uncertain by the rounding over the height of the triangle.
bool holds(const TriangleMesh& hull, const Points& points, double size)
{
    constexpr std::size_t kMostHeights = 100'000'000;
    const std::size_t stride = 1 + hull.triangles.size() * points.size() / kMostHeights;
    for (const Triangle& t : hull.triangles)
    {
        const Eigen::Vector3d& a = hull.vertices[std::size_t(t[0])];
        const Eigen::Vector3d normal =
            (hull.vertices[std::size_t(t[1])] - a).cross(hull.vertices[std::size_t(t[2])] - a);
        const double tolerance = kOutside * size * normal.norm() + kRounding * size * size * size;
        for (std::size_t i = 0; i < points.size(); i += stride)
        {
            if (!(normal.dot(points[i] - a) <= tolerance))
            {
                return false;
            }
        }
    }
    return bullet_ccd::isWatertight(hull);
}

/// Integer arithmetic: never fails, but rounds to 1e-4 of the size.
TriangleMesh roundedHull(const Points& points)
{
    std::vector<double> coordinates;
    for (const Eigen::Vector3d& point : points)
    {
        coordinates.insert(coordinates.end(), point.data(), point.data() + 3);
    }
    btConvexHullComputer computer;
    computer.compute(coordinates.data(), int(3 * sizeof(double)), int(points.size()), 0, 0);
    TriangleMesh mesh;
    for (int i = 0; i < computer.vertices.size(); ++i)
    {
        mesh.vertices.push_back(points[std::size_t(computer.original_vertex_index[i])]);
    }
    for (int i = 0; i < computer.faces.size(); ++i)
    {
        const auto* first = &computer.edges[computer.faces[i]];
        const auto* edge = first->getNextEdgeOfFace();
        for (; edge->getTargetVertex() != first->getSourceVertex();
             edge = edge->getNextEdgeOfFace())
        {
            mesh.triangles.push_back(
                {first->getSourceVertex(), edge->getSourceVertex(), edge->getTargetVertex()});
        }
    }
    return mesh;
}
}  // namespace

TriangleMesh btCcdHullMesh(const Points& points)
{
    bullet_ccd::require(!points.empty() && std::all_of(points.begin(),
                                                       points.end(),
                                                       [](const Eigen::Vector3d& point)
                                                       { return point.allFinite(); }),
                        "btCcdHullMesh: no points, or one that is not finite: give all points of "
                        "the hull");
    // The largest tetrahedron that can be had cheaply: ends, then farthest from the line, then from
    // the plane.
    const std::int32_t a = largest(points, [](const Eigen::Vector3d& p) { return p.x(); });
    const Eigen::Vector3d& first = points[std::size_t(a)];
    const std::int32_t b =
        largest(points, [&](const Eigen::Vector3d& p) { return (p - first).squaredNorm(); });
    const Eigen::Vector3d span = points[std::size_t(b)] - first;
    const double size = span.norm();
    if (size == 0.0)
    {
        return {{first}, {Triangle{0, 0, 0}}};
    }
    const Eigen::Vector3d along = span / size;
    const auto fromLine = [&](const Eigen::Vector3d& p)
    { return Eigen::Vector3d((p - first) - along.dot(p - first) * along); };
    const std::int32_t c =
        largest(points, [&](const Eigen::Vector3d& p) { return fromLine(p).squaredNorm(); });
    const Eigen::Vector3d side = fromLine(points[std::size_t(c)]);
    if (side.norm() <= kRounding * size)
    {
        const std::int32_t other =
            largest(points, [&](const Eigen::Vector3d& p) { return -along.dot(p - first); });
        return {{points[std::size_t(other)], points[std::size_t(b)]}, {Triangle{0, 1, 1}}};
    }
    const Eigen::Vector3d normal = along.cross(side).normalized();
    const auto fromPlane = [&](const Eigen::Vector3d& p)
    { return std::abs(normal.dot(p - first)); };
    const std::int32_t d = largest(points, fromPlane);
    if (fromPlane(points[std::size_t(d)]) <= kRounding * size)
    {
        return flatHull(points, along, side.normalized());
    }
    TriangleMesh hull = compact(points, Quickhull(points, size).run({a, b, c}, d));
    return holds(hull, points, size) ? hull : roundedHull(points);
}
