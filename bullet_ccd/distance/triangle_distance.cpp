#include "bullet_ccd/distance/triangle_distance.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

/// Best pair of points so far.
struct Closest
{
    double squared = std::numeric_limits<double>::infinity();
    Vector3d a = Vector3d::Zero();
    Vector3d b = Vector3d::Zero();

    void consider(const Vector3d& pointA, const Vector3d& pointB)
    {
        const double d = (pointB - pointA).squaredNorm();
        if (d < squared)
        {
            squared = d;
            a = pointA;
            b = pointB;
        }
    }
};

/// Point of the segment p + s (q - p), s in [0, 1]; the ends exactly, so that a corner shared by
/// several triangles gives the same witness for each.
Vector3d pointOn(const Vector3d& p, const Vector3d& q, double s)
{
    return s <= 0.0 ? p : (s >= 1.0 ? q : Vector3d(p + s * (q - p)));
}

/// Parameter of the point of the segment closest to x; 0 for a segment of length 0.
double closestParameter(const Vector3d& p, const Vector3d& q, const Vector3d& x)
{
    const Vector3d d = q - p;
    const double squared = d.squaredNorm();
    return squared > 0.0 ? std::clamp(d.dot(x - p) / squared, 0.0, 1.0) : 0.0;
}

/// Closest points of two segments. The crossing of the two lines is found with their cross product,
/// whose relative error is that of the angle and not of its square: almost parallel edges lose
/// nothing. Alternating projections then clamp it, and the four ends decide where it does not
/// apply.
void considerEdges(
    const Vector3d& p0, const Vector3d& p1, const Vector3d& q0, const Vector3d& q1, Closest& best)
{
    const Vector3d u = p1 - p0;
    const Vector3d v = q1 - q0;
    const Vector3d n = u.cross(v);
    const double nn = n.squaredNorm();
    double s = 0.0;
    if (nn > 0.0)
    {
        s = std::clamp((q0 - p0).cross(v).dot(n) / nn, 0.0, 1.0);
    }
    const double t = closestParameter(q0, q1, pointOn(p0, p1, s));
    const Vector3d onQ = pointOn(q0, q1, t);
    const Vector3d onP = pointOn(p0, p1, closestParameter(p0, p1, onQ));
    best.consider(onP, pointOn(q0, q1, closestParameter(q0, q1, onP)));
}

/// Distance of every corner of one triangle from the inside of the other, and of an edge that
/// pierces it. `swap` says which of the two is A.
struct Face
{
    const TriangleCorners& c;
    Vector3d normal;
    double normalSquared;

    explicit Face(const TriangleCorners& corners)
        : c(corners),
          normal((corners[1] - corners[0]).cross(corners[2] - corners[0])),
          normalSquared(normal.squaredNorm())
    {
    }

    /// A normal worth projecting along: a triangle with height below 1e-13 of its length is an
    /// edge.
    [[nodiscard]] bool hasArea() const
    {
        const double longest = std::max({(c[1] - c[0]).squaredNorm(),
                                         (c[2] - c[1]).squaredNorm(),
                                         (c[0] - c[2]).squaredNorm()});
        return normalSquared > 1e-26 * longest * longest;
    }

    /// Where the line through x along the normal meets the triangle, if it does: a convex
    /// combination of its corners, so a point of it however wrong the normal of a sliver is.
    [[nodiscard]] std::optional<Vector3d> foot(const Vector3d& x) const
    {
        Vector3d sum = Vector3d::Zero();
        double weights = 0.0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Vector3d& p = c[k];
            const Vector3d& q = c[(k + 1) % 3];
            const double weight = (q - p).cross(x - p).dot(normal);
            if (weight < 0.0)
            {
                return std::nullopt;
            }
            sum += weight * (c[(k + 2) % 3] - c[0]);
            weights += weight;
        }
        return weights > 0.0 ? std::optional<Vector3d>(c[0] + sum / weights) : std::nullopt;
    }

    [[nodiscard]] double height(const Vector3d& x) const
    {
        return (x - c[0]).dot(normal);  // times |normal|
    }
};

/// True if a plane certainly separates the triangles: what seems to pierce a sliver need not,
/// because the normal of a sliver is uncertain.
bool areSeparated(const TriangleCorners& a, const TriangleCorners& b)
{
    double size = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
    {
        size = std::max({size, (a[k] - a[0]).norm(), (b[k] - a[0]).norm()});
    }
    const auto separates = [&](const Vector3d& n)
    {
        double lowA = 0.0;
        double highA = 0.0;
        double lowB = std::numeric_limits<double>::infinity();
        double highB = -lowB;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const double heightA = n.dot(a[k] - a[0]);
            const double heightB = n.dot(b[k] - a[0]);
            lowA = std::min(lowA, heightA);
            highA = std::max(highA, heightA);
            lowB = std::min(lowB, heightB);
            highB = std::max(highB, heightB);
        }
        constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
        return std::max(lowB - highA, lowA - highB) > kRounding * size * n.norm();
    };
    const auto edge = [](const TriangleCorners& c, std::size_t k)
    { return Vector3d(c[(k + 1) % 3] - c[k]); };
    if (separates(edge(a, 0).cross(edge(a, 1))) || separates(edge(b, 0).cross(edge(b, 1))))
    {
        return true;
    }
    for (std::size_t i = 0; i < 9; ++i)
    {
        if (separates(edge(a, i / 3).cross(edge(b, i % 3))))
        {
            return true;
        }
    }
    return false;
}

/// Corners of `other` over the face, and edges of `other` through it.
template <bool kFaceIsA>
void considerFace(const Face& face, const TriangleCorners& other, Closest& best)
{
    const auto consider = [&](const Vector3d& onFace, const Vector3d& onOther)
    { kFaceIsA ? best.consider(onFace, onOther) : best.consider(onOther, onFace); };

    std::array<double, 3> heights{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        heights[k] = face.height(other[k]);
        if (const std::optional<Vector3d> foot = face.foot(other[k]))
        {
            consider(*foot, other[k]);
        }
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
        const std::size_t l = (k + 1) % 3;
        if ((heights[k] > 0.0) == (heights[l] > 0.0))
        {
            continue;
        }
        const Vector3d through =
            other[k] + (heights[k] / (heights[k] - heights[l])) * (other[l] - other[k]);
        if (face.foot(through))
        {
            if (!areSeparated(face.c, other))
            {
                consider(through, through);
            }
            return;
        }
    }
}
/// True if all corners of `other` are farther than `distance` from the plane of `c`, on one side.
bool allBeyond(const TriangleCorners& c, const TriangleCorners& other, double distance)
{
    const Vector3d normal = (c[1] - c[0]).cross(c[2] - c[0]);
    const std::array<Vector3d, 3> away{other[0] - c[0], other[1] - c[0], other[2] - c[0]};
    const std::array<double, 3> heights{
        away[0].dot(normal), away[1].dot(normal), away[2].dot(normal)};
    const auto [low, high] = std::minmax({heights[0], heights[1], heights[2]});
    const double height = low > 0.0 ? low : -high;
    if (!(height > 0.0))
    {
        return false;
    }
    // The normal errs by a few roundings of the product of the edges' lengths.
    constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
    const double lengths = std::max((c[1] - c[0]).squaredNorm(), (c[2] - c[0]).squaredNorm());
    const double farthest =
        std::max({away[0].squaredNorm(), away[1].squaredNorm(), away[2].squaredNorm()});
    const double certain = height - kRounding * lengths * std::sqrt(farthest);
    return certain > distance * normal.norm() * (1.0 + kRounding);
}
}  // namespace

TriangleDistance pointToTriangle(const Eigen::Vector3d& point, const TriangleCorners& triangle)
{
    Closest best;
    const Face face(triangle);
    const std::optional<Vector3d> foot = face.hasArea() ? face.foot(point) : std::nullopt;
    if (foot)
    {
        best.consider(point, *foot);
    }
    else
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Vector3d& p = triangle[k];
            const Vector3d& q = triangle[(k + 1) % 3];
            best.consider(point, pointOn(p, q, closestParameter(p, q, point)));
        }
    }
    return {.distance = std::sqrt(best.squared), .pointA = best.a, .pointB = best.b};
}

TriangleDistance segmentToSegment(const Eigen::Vector3d& p0,
                                  const Eigen::Vector3d& p1,
                                  const Eigen::Vector3d& q0,
                                  const Eigen::Vector3d& q1)
{
    Closest best;
    considerEdges(p0, p1, q0, q1, best);
    return {.distance = std::sqrt(best.squared), .pointA = best.a, .pointB = best.b};
}

bool planeShowsFarther(const TriangleCorners& a, const TriangleCorners& b, double distance)
{
    return allBeyond(a, b, distance) || allBeyond(b, a, distance);
}

TriangleDistance triangleDistance(const TriangleCorners& a, const TriangleCorners& b)
{
    Closest best;
    for (std::size_t i = 0; i < 3; ++i)
    {
        for (std::size_t j = 0; j < 3; ++j)
        {
            considerEdges(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3], best);
        }
    }
    const Face faceA(a);
    const Face faceB(b);
    if (faceA.hasArea())
    {
        considerFace<true>(faceA, b, best);
    }
    if (faceB.hasArea())
    {
        considerFace<false>(faceB, a, best);
    }
    return {.distance = std::sqrt(best.squared), .pointA = best.a, .pointB = best.b};
}
}  // namespace bullet_ccd
