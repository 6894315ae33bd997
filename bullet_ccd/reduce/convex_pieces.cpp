#include "bullet_ccd/reduce/convex_pieces.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/reduce/convex_hull.h"
#include "bullet_ccd/reduce/simple_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

constexpr double kThickness = 0.1;       // of what is flat, over the accuracy
constexpr std::size_t kCells = 8;        // for each piece, that are merged into it
constexpr std::size_t kTriangles = 150;  // of a part, by which it is judged, at the least
constexpr double kNearCorner = 0.95;
constexpr double kOwn = 1e-9;      // of a ray, within which it is on its own triangle
constexpr double kGrazing = 1e-3;  // of facets along a normal

/// The half-space below it is normal . x < offset.
struct Plane
{
    Vector3d normal = Vector3d::Zero();
    double offset = 0.0;

    [[nodiscard]] double above(const Vector3d& point) const { return normal.dot(point) - offset; }
};

/// A part of the surface and what stands for it.
struct Part
{
    TriangleMesh surface;
    TriangleMesh hull;
    double bulge = 0.0;
    double excess = 0.0;  ///< volume between hull and surface
};

const Vector3d& corner(const TriangleMesh& mesh, const Triangle& triangle, std::size_t k)
{
    return mesh.vertices[static_cast<std::size_t>(triangle[k])];
}

/// Where the edge between the two points meets the plane.
Vector3d crossing(const Plane& plane, const Vector3d& a, const Vector3d& b)
{
    const double from = plane.above(a);
    return a + from / (from - plane.above(b)) * (b - a);
}

/// The convex hull; of what is flat or straight, that of it with a thickness.
TriangleMesh solidHull(const TriangleMesh& mesh, double thickness)
{
    if (TriangleMesh hull = convexHull(mesh); !hull.triangles.empty())
    {
        return hull;
    }
    const MeshFrame frame = meshFrames(mesh)[1];
    Eigen::Index thin = 0;
    frame.half.minCoeff(&thin);
    TriangleMesh thick;
    for (const double side : {-0.5, 0.5})
    {
        for (const Vector3d& vertex : mesh.vertices)
        {
            thick.vertices.emplace_back(vertex + side * thickness * frame.pose.linear().col(thin));
        }
    }
    if (TriangleMesh hull = convexHull(thick); !hull.triangles.empty())
    {
        return hull;
    }
    TriangleMesh box = makeBox(frame.half.cwiseMax(0.5 * thickness));
    transformMesh(box, Eigen::Affine3d(frame.pose));
    return box;
}

std::vector<Plane> facetsOf(const TriangleMesh& hull)
{
    std::vector<Plane> facets;
    for (const Triangle& t : hull.triangles)
    {
        const Vector3d& a = corner(hull, t, 0);
        const Vector3d across = (corner(hull, t, 1) - a).cross(corner(hull, t, 2) - a);
        if (across.norm() > 0.0)
        {
            facets.push_back({across.normalized(), across.normalized().dot(a)});
        }
    }
    return facets;
}

/// How far it is from the point along the normal to where it leaves the hull.
double depthOf(const std::vector<Plane>& facets, const Vector3d& point, const Vector3d& normal)
{
    double depth = std::numeric_limits<double>::infinity();
    for (const Plane& facet : facets)
    {
        const double along = facet.normal.dot(normal);
        if (along > kGrazing)
        {
            depth = std::min(depth, -facet.above(point) / along);
        }
    }
    return std::isfinite(depth) ? std::max(depth, 0.0) : 0.0;
}

/// How far it is along the unit direction to the next triangle of the mesh, if less than `far`.
double nextSurface(const TriangleMesh& mesh,
                   const Vector3d& point,
                   const Vector3d& direction,
                   double far)
{
    for (const Triangle& t : mesh.triangles)
    {
        const Vector3d& a = corner(mesh, t, 0);
        const Vector3d ab = corner(mesh, t, 1) - a;
        const Vector3d ac = corner(mesh, t, 2) - a;
        const Vector3d across = ab.cross(ac);
        const double slope = across.dot(direction);
        if (slope == 0.0)
        {
            continue;
        }
        const double way = across.dot(a - point) / slope;
        if (!(way > kOwn * far && way < far))
        {
            continue;
        }
        const Vector3d hit = point + way * direction - a;
        const double u = hit.cross(ac).dot(across);
        const double v = ab.cross(hit).dot(across);
        if (u >= 0.0 && v >= 0.0 && u + v <= across.squaredNorm())
        {
            far = way;
        }
    }
    return far;
}

void judge(Part& part, double accuracy)
{
    const std::vector<Plane> facets = facetsOf(part.hull);
    const std::size_t step = 1 + part.surface.triangles.size() / kTriangles;
    for (std::size_t i = 0; i < part.surface.triangles.size(); i += step)
    {
        const Triangle& t = part.surface.triangles[i];
        const Vector3d& a = corner(part.surface, t, 0);
        const Vector3d& b = corner(part.surface, t, 1);
        const Vector3d& c = corner(part.surface, t, 2);
        const Vector3d across = (b - a).cross(c - a);
        if (!(across.norm() > 0.0))
        {
            continue;
        }
        const Vector3d normal = across.normalized();
        const Vector3d middle = (a + b + c) / 3.0;
        double deepest = 0.0;
        for (const Vector3d& point : {middle,
                                      Vector3d(middle + kNearCorner * (a - middle)),
                                      Vector3d(middle + kNearCorner * (b - middle)),
                                      Vector3d(middle + kNearCorner * (c - middle))})
        {
            double depth = depthOf(facets, point, normal);
            if (depth > accuracy)
            {
                depth = nextSurface(part.surface, point, normal, depth);
            }
            deepest = std::max(deepest, depth);
        }
        part.bulge = std::max(part.bulge, deepest);
        part.excess += 0.5 * across.norm() * deepest * static_cast<double>(step);
    }
}

Part makePart(TriangleMesh surface, double accuracy)
{
    Part part{.surface = std::move(surface), .hull = {}};
    part.hull = solidHull(part.surface, kThickness * accuracy);
    judge(part, accuracy);
    return part;
}

/// The part of the surface above the plane, or below it.
TriangleMesh clipped(const TriangleMesh& mesh, const Plane& plane, bool isAbove)
{
    TriangleMesh result;
    std::vector<std::int32_t> kept(mesh.vertices.size(), kNone);
    const auto add = [&](const Vector3d& point)
    {
        result.vertices.push_back(point);
        return static_cast<std::int32_t>(result.vertices.size()) - 1;
    };
    const auto isKept = [&](const Vector3d& point)
    { return (plane.above(point) >= 0.0) == isAbove; };
    for (const Triangle& t : mesh.triangles)
    {
        std::array<std::int32_t, 4> polygon{};
        std::size_t count = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Vector3d& here = corner(mesh, t, k);
            const Vector3d& next = corner(mesh, t, (k + 1) % 3);
            if (isKept(here))
            {
                std::int32_t& index = kept[static_cast<std::size_t>(t[k])];
                index = index == kNone ? add(here) : index;
                polygon[count++] = index;
            }
            if (isKept(here) != isKept(next))
            {
                polygon[count++] = add(crossing(plane, here, next));
            }
        }
        for (std::size_t k = 2; k < count; ++k)
        {
            result.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
        }
    }
    return result;
}

/// Across the longest axis of the part, in the middle.
Plane middlePlane(const TriangleMesh& surface)
{
    const MeshFrame frame = meshFrames(surface)[1];
    Eigen::Index longest = 0;
    frame.half.maxCoeff(&longest);
    const Vector3d normal = frame.pose.linear().col(longest);
    return {normal, normal.dot(frame.pose.translation())};
}

/// Cuts what bulges too much until nothing does or there are too many parts.
std::vector<Part> cells(const TriangleMesh& mesh, double accuracy, std::size_t most)
{
    std::vector<Part> parts;
    parts.push_back(makePart(mesh, accuracy));
    while (parts.size() < most)
    {
        const auto urgency = [&](const Part& part)
        { return part.bulge > accuracy ? part.excess : 0.0; };
        const auto worst = std::ranges::max_element(parts, {}, urgency);
        if (!(urgency(*worst) > 0.0))
        {
            break;
        }
        const Plane plane = middlePlane(worst->surface);
        TriangleMesh above = clipped(worst->surface, plane, true);
        TriangleMesh below = clipped(worst->surface, plane, false);
        if (above.triangles.empty() || below.triangles.empty())
        {
            worst->excess = 0.0;  // no plane cuts it
            continue;
        }
        *worst = makePart(std::move(above), accuracy);
        parts.push_back(makePart(std::move(below), accuracy));
    }
    return parts;
}

}  // namespace

ConvexPieces convexPieces(const TriangleMesh& mesh, const ConvexPiecesOptions& options)
{
    checkMesh(mesh, "convexPieces");
    require(
        std::isfinite(options.accuracy) && options.accuracy > 0.0,
        "convexPieces: accuracy " + std::to_string(options.accuracy) + " m: give a positive one");
    require(options.most >= 1, "convexPieces: no pieces are allowed: allow 1 or more");
    std::vector<Part> parts = cells(mesh, options.accuracy, options.most);
    ConvexPieces result;
    for (Part& part : parts)
    {
        result.bulge = std::max(result.bulge, part.bulge);
        result.pieces.push_back(std::move(part.hull));
    }
    return result;
}
}  // namespace bullet_ccd
