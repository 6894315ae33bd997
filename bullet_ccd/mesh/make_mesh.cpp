#include "bullet_ccd/math/check.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

namespace bullet_ccd
{
namespace
{
constexpr double kPi = std::numbers::pi;

void requirePositive(double value, const char* what)
{
    if (!(value > 0.0 && std::isfinite(value)))
    {
        throw std::invalid_argument(std::string(what) + " is " + std::to_string(value) +
                                    ": it must be positive and finite");
    }
}

void requireAtLeast(std::int64_t value, std::int64_t least, const char* what)
{
    if (value < least)
    {
        throw std::invalid_argument(std::string(what) + " is " + std::to_string(value) +
                                    ": it must be at least " + std::to_string(least));
    }
}

TriangleMesh makeIcosahedron()
{
    const double g = std::numbers::phi;
    TriangleMesh mesh;
    mesh.vertices = {{-1, g, 0},
                     {1, g, 0},
                     {-1, -g, 0},
                     {1, -g, 0},
                     {0, -1, g},
                     {0, 1, g},
                     {0, -1, -g},
                     {0, 1, -g},
                     {g, 0, -1},
                     {g, 0, 1},
                     {-g, 0, -1},
                     {-g, 0, 1}};
    mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    return mesh;
}

/// Splits every triangle into four; new vertices are edge midpoints, shared by both sides.
TriangleMesh subdivided(const TriangleMesh& mesh)
{
    TriangleMesh result;
    result.vertices = mesh.vertices;
    result.triangles.reserve(4 * mesh.triangles.size());
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> midpoints;
    const auto midpoint = [&](std::int32_t i, std::int32_t j)
    {
        const auto [entry, isNew] = midpoints.try_emplace(
            std::minmax(i, j), static_cast<std::int32_t>(result.vertices.size()));
        if (isNew)
        {
            const Eigen::Vector3d middle = 0.5 * (mesh.vertices[static_cast<std::size_t>(i)] +
                                                  mesh.vertices[static_cast<std::size_t>(j)]);
            result.vertices.push_back(middle);
        }
        return entry->second;
    };
    for (const auto& [a, b, c] : mesh.triangles)
    {
        const std::int32_t ab = midpoint(a, b);
        const std::int32_t bc = midpoint(b, c);
        const std::int32_t ca = midpoint(c, a);
        result.triangles.insert(result.triangles.end(),
                                {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return result;
}

/// Vertices of one ring of a surface of revolution or of a loft; a pole has one.
struct Ring
{
    std::int32_t first = 0;
    std::int32_t count = 0;

    [[nodiscard]] std::int32_t vertex(std::int32_t i) const { return first + i % count; }
};

/// Joins two rings around; `upper` follows `lower` in the direction that makes the winding outward.
void addBand(TriangleMesh& mesh, const Ring& lower, const Ring& upper)
{
    const std::int32_t segments = std::max(lower.count, upper.count);
    for (std::int32_t i = 0; segments > 1 && i < segments; ++i)
    {
        if (lower.count > 1)
        {
            mesh.triangles.push_back({lower.vertex(i), lower.vertex(i + 1), upper.vertex(i + 1)});
        }
        if (upper.count > 1)
        {
            mesh.triangles.push_back({lower.vertex(i), upper.vertex(i + 1), upper.vertex(i)});
        }
    }
}

Ring addRing(TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& points)
{
    const bool isPole = std::ranges::all_of(points, [&](const auto& p) { return p == points[0]; });
    const Ring ring{static_cast<std::int32_t>(mesh.vertices.size()),
                    isPole ? 1 : static_cast<std::int32_t>(points.size())};
    mesh.vertices.insert(mesh.vertices.end(), points.begin(), points.begin() + ring.count);
    return ring;
}

/// A pole in the mean of the ring.
Ring addCapPole(TriangleMesh& mesh, const Ring& ring)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::int32_t i = 0; i < ring.count; ++i)
    {
        sum += mesh.vertices[static_cast<std::size_t>(ring.vertex(i))];
    }
    return addRing(mesh, {sum / static_cast<double>(ring.count)});
}

Eigen::Vector2d polar(double radius, double angle)
{
    return {radius * std::cos(angle), radius * std::sin(angle)};
}
}  // namespace

TriangleMesh makeBox(const Eigen::Vector3d& halfExtents)
{
    requirePositive(halfExtents.minCoeff(), "makeBox: smallest half extent");
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i)
    {
        const Eigen::Vector3d sign(
            (i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
        mesh.vertices.emplace_back(sign.cwiseProduct(halfExtents));
    }
    mesh.triangles = {{0, 2, 3},
                      {0, 3, 1},
                      {4, 5, 7},
                      {4, 7, 6},
                      {0, 1, 5},
                      {0, 5, 4},
                      {2, 6, 7},
                      {2, 7, 3},
                      {0, 4, 6},
                      {0, 6, 2},
                      {1, 3, 7},
                      {1, 7, 5}};
    return mesh;
}

TriangleMesh makeSphere(double radius, int subdivisions)
{
    requirePositive(radius, "makeSphere: radius");
    requireAtLeast(subdivisions, 0, "makeSphere: number of subdivisions");
    TriangleMesh mesh = makeIcosahedron();
    for (int i = 0; i < subdivisions; ++i)
    {
        for (Eigen::Vector3d& vertex : mesh.vertices)
        {
            vertex.normalize();
        }
        mesh = subdivided(mesh);
    }
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex *= radius / vertex.norm();
    }
    return mesh;
}

TriangleMesh makeCylinder(double radius, double height, int segments)
{
    requirePositive(radius, "makeCylinder: radius");
    requirePositive(height, "makeCylinder: height");
    const double half = 0.5 * height;
    return makeRevolved({{0, -half}, {radius, -half}, {radius, half}, {0, half}}, segments);
}

TriangleMesh makeCapsule(double radius, double height, int segments)
{
    requirePositive(radius, "makeCapsule: radius");
    requireAtLeast(segments, 3, "makeCapsule: number of segments");
    require(height >= 0.0, "makeCapsule: height is negative or NaN: it must be at least 0");
    const int steps = std::max(1, (segments + 2) / 4);  // near-square facets at the equator
    std::vector<Eigen::Vector2d> profile;
    for (int side = -1; side <= 1; side += 2)
    {
        const double start = side < 0 ? -0.5 * kPi : 0.0;
        // At height 0 both hemispheres share the equator.
        for (int i = side > 0 && height == 0.0 ? 1 : 0; i <= steps; ++i)
        {
            const bool isPole = side < 0 ? i == 0 : i == steps;
            const Eigen::Vector2d onArc = polar(radius, start + 0.5 * kPi * i / steps);
            profile.emplace_back(isPole ? 0.0 : onArc.x(), onArc.y() + 0.5 * side * height);
        }
    }
    return makeRevolved(profile, segments);
}

TriangleMesh makeTorus(double majorRadius, double minorRadius, int majorSegments, int minorSegments)
{
    requirePositive(minorRadius, "makeTorus: minor radius");
    requirePositive(majorRadius - minorRadius, "makeTorus: major less minor radius");
    requireAtLeast(minorSegments, 3, "makeTorus: number of minor segments");
    std::vector<Eigen::Vector2d> profile;
    for (int i = 0; i < minorSegments; ++i)
    {
        profile.emplace_back(polar(minorRadius, 2.0 * kPi * i / minorSegments) +
                             Eigen::Vector2d(majorRadius, 0.0));
    }
    return makeRevolved(profile, majorSegments);
}

TriangleMesh makeRevolved(const std::vector<Eigen::Vector2d>& profile, int segments)
{
    requireAtLeast(segments, 3, "makeRevolved: number of segments");
    requireAtLeast(static_cast<std::int64_t>(profile.size()), 3, "makeRevolved: number of points");
    TriangleMesh mesh;
    std::vector<Ring> rings;
    for (const Eigen::Vector2d& point : profile)
    {
        require(point.x() >= 0.0 && point.allFinite(),
                "makeRevolved: a profile radius is negative or not finite: it must be at least 0");
        std::vector<Eigen::Vector3d> ring;
        for (int i = 0; i < segments; ++i)
        {
            const Eigen::Vector2d xy = polar(point.x(), 2.0 * kPi * i / segments);
            ring.emplace_back(xy.x() + 0.0, xy.y() + 0.0, point.y());
        }
        rings.push_back(addRing(mesh, ring));
    }
    for (std::size_t i = 0; i < rings.size(); ++i)
    {
        addBand(mesh, rings[i], rings[(i + 1) % rings.size()]);
    }
    return mesh;
}

TriangleMesh makeLofted(const std::function<std::vector<Eigen::Vector3d>(int station)>& section,
                        int stations)
{
    requireAtLeast(stations, 2, "makeLofted: number of stations");
    TriangleMesh mesh;
    std::vector<Ring> rings;
    std::size_t count = 0;
    for (int station = 0; station < stations; ++station)
    {
        const std::vector<Eigen::Vector3d> points = section(station);
        requireAtLeast(static_cast<std::int64_t>(points.size()),
                       3,
                       "makeLofted: number of points in a section");
        count = station == 0 ? points.size() : count;
        require(points.size() == count,
                "makeLofted: sections differ in their number of points: all must have the same");
        rings.push_back(addRing(mesh, points));
    }
    for (std::size_t i = 0; i + 1 < rings.size(); ++i)
    {
        addBand(mesh, rings[i], rings[i + 1]);
    }
    const Ring first = rings.front();
    const Ring last = rings.back();
    if (first.count > 1)
    {
        addBand(mesh, addCapPole(mesh, first), first);
    }
    if (last.count > 1)
    {
        addBand(mesh, last, addCapPole(mesh, last));
    }
    return mesh;
}

TriangleMesh makeTriangle(const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b,
                          const Eigen::Vector3d& c)
{
    return {{a, b, c}, {{0, 1, 2}}};
}
}  // namespace bullet_ccd
