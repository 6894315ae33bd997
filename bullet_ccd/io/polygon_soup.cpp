#include "bullet_ccd/io/polygon_soup.h"

#include <Eigen/Geometry>

#include <span>
#include <stdexcept>
#include <utility>

namespace bullet_ccd
{
namespace
{
const Eigen::Vector3d& vertex(const std::vector<Eigen::Vector3d>& vertices, std::int32_t index)
{
    return vertices[static_cast<std::size_t>(index)];
}

/// Twice the area vector of a polygon (Newell), relative to its first corner.
Eigen::Vector3d areaVector(const std::vector<Eigen::Vector3d>& vertices,
                           std::span<const std::int32_t> ring)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const Eigen::Vector3d& origin = vertex(vertices, ring[0]);
    for (std::size_t i = 1; i + 1 < ring.size(); ++i)
    {
        sum += (vertex(vertices, ring[i]) - origin).cross(vertex(vertices, ring[i + 1]) - origin);
    }
    return sum;
}

/// True if the corner `i` of the ring is convex and no other corner lies in its triangle.
bool isEar(const std::vector<Eigen::Vector3d>& vertices,
           const std::vector<std::int32_t>& ring,
           std::size_t i,
           const Eigen::Vector3d& normal)
{
    const std::size_t n = ring.size();
    const Eigen::Vector3d& a = vertex(vertices, ring[(i + n - 1) % n]);
    const Eigen::Vector3d& b = vertex(vertices, ring[i]);
    const Eigen::Vector3d& c = vertex(vertices, ring[(i + 1) % n]);
    const auto side =
        [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& p)
    { return (to - from).cross(p - from).dot(normal); };
    if (side(a, b, c) <= 0.0)
    {
        return false;
    }
    for (std::size_t k = 2; k + 1 < n; ++k)
    {
        const Eigen::Vector3d& p = vertex(vertices, ring[(i + k) % n]);
        if (p != a && p != b && p != c && side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 &&
            side(c, a, p) >= 0.0)
        {
            return false;
        }
    }
    return true;
}

/// Cuts ears until a triangle is left; what has no ear any more becomes a fan.
void clipEars(const std::vector<Eigen::Vector3d>& vertices,
              std::vector<std::int32_t> ring,
              std::vector<Triangle>& triangles)
{
    const Eigen::Vector3d normal = areaVector(vertices, ring);
    std::size_t i = 1;
    std::size_t rejected = 0;
    while (ring.size() > 3 && rejected < ring.size())
    {
        i %= ring.size();
        if (!isEar(vertices, ring, i, normal))
        {
            ++i;
            ++rejected;
            continue;
        }
        const std::size_t n = ring.size();
        triangles.push_back({ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
        rejected = 0;
    }
    for (std::size_t k = 1; k + 1 < ring.size(); ++k)
    {
        triangles.push_back({ring[0], ring[k], ring[k + 1]});
    }
}

void requireVertices(std::span<const std::int32_t> ring,
                     std::size_t polygon,
                     std::size_t vertices,
                     const std::string& name)
{
    for (const std::int32_t corner : ring)
    {
        if (corner < 0 || static_cast<std::size_t>(corner) >= vertices)
        {
            throw std::runtime_error(name + ": face " + std::to_string(polygon) +
                                     ": vertex index " + std::to_string(corner) +
                                     " is outside [0, " + std::to_string(vertices) +
                                     "): export the mesh again");
        }
    }
}
}  // namespace

TriangleMesh triangulate(PolygonSoup soup, const std::string& name)
{
    // Ear clipping is cubic in the worst case; nothing real has larger polygons than this.
    constexpr std::size_t kMaxClippedCorners = 1000;

    TriangleMesh mesh;
    mesh.vertices = std::move(soup.vertices);
    mesh.triangles.reserve(soup.polygonEnds.size());
    std::size_t begin = 0;
    for (std::size_t polygon = 0; polygon < soup.polygonEnds.size(); ++polygon)
    {
        const std::size_t end = soup.polygonEnds[polygon];
        const std::span<const std::int32_t> ring(soup.corners.data() + begin, end - begin);
        begin = end;
        requireVertices(ring, polygon, mesh.vertices.size(), name);
        if (ring.size() > 3 && ring.size() <= kMaxClippedCorners)
        {
            clipEars(mesh.vertices, {ring.begin(), ring.end()}, mesh.triangles);
            continue;
        }
        for (std::size_t k = 1; k + 1 < ring.size(); ++k)
        {
            mesh.triangles.push_back({ring[0], ring[k], ring[k + 1]});
        }
    }
    return mesh;
}
}  // namespace bullet_ccd
