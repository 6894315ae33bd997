#include "benchmarks/reference/oracles/closest_features.h"

#include <algorithm>
#include <limits>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

/// Closest points of the segments p0 p1 and q0 q1, in double: good for a direction.
void closestOfSegments(const Vector3d& p0,
                       const Vector3d& p1,
                       const Vector3d& q0,
                       const Vector3d& q1,
                       InstantDistance& best)
{
    const Vector3d u = p1 - p0;
    const Vector3d v = q1 - q0;
    const Vector3d w = p0 - q0;
    const double a = u.squaredNorm();
    const double e = v.squaredNorm();
    const double b = u.dot(v);
    const double c = u.dot(w);
    const double f = v.dot(w);
    const double det = a * e - b * b;
    double s = det > 1e-14 * a * e ? std::clamp((b * f - c * e) / det, 0.0, 1.0) : 0.0;
    double t = e > 0.0 ? (b * s + f) / e : 0.0;
    if (t < 0.0 || t > 1.0)
    {
        t = std::clamp(t, 0.0, 1.0);
    }
    s = a > 0.0 ? std::clamp((b * t - c) / a, 0.0, 1.0) : 0.0;
    const Vector3d onA = p0 + s * u;
    const Vector3d onB = q0 + t * v;
    const double distance = (onB - onA).norm();
    if (distance < best.distance)
    {
        best = {.distance = distance, .pointA = onA, .pointB = onB};
    }
}

/// A triangle with what it takes to drop perpendiculars on it; none if it has no area.
struct Face
{
    explicit Face(const std::array<Vector3d, 3>& corners) : t(corners)
    {
        normal = (t[1] - t[0]).cross(t[2] - t[0]);
        area = normal.squaredNorm();
        for (std::size_t k = 0; k < 3; ++k)
        {
            inwards[k] = normal.cross(t[(k + 1) % 3] - t[k]);
        }
    }

    /// Offers the foot of the perpendicular from `point`, if it is inside.
    [[nodiscard]] bool foot(const Vector3d& point, Vector3d& result) const
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            if (!(area > 0.0) || inwards[k].dot(point - t[k]) < 0.0)
            {
                return false;
            }
        }
        result = point - normal.dot(point - t[0]) / area * normal;
        return true;
    }

    const std::array<Vector3d, 3>& t;
    Vector3d normal;
    double area;
    std::array<Vector3d, 3> inwards;
};
}  // namespace

InstantDistance closestFeatures(const std::array<Vector3d, 3>& a, const std::array<Vector3d, 3>& b)
{
    InstantDistance best{.distance = std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < 3; ++i)
    {
        for (std::size_t j = 0; j < 3; ++j)
        {
            closestOfSegments(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3], best);
        }
    }
    const Face faceA(a);
    const Face faceB(b);
    Vector3d foot;
    for (std::size_t i = 0; i < 3; ++i)
    {
        if (faceB.foot(a[i], foot) && (foot - a[i]).norm() < best.distance)
        {
            best = {.distance = (foot - a[i]).norm(), .pointA = a[i], .pointB = foot};
        }
        if (faceA.foot(b[i], foot) && (foot - b[i]).norm() < best.distance)
        {
            best = {.distance = (foot - b[i]).norm(), .pointA = foot, .pointB = b[i]};
        }
    }
    return best;
}
}  // namespace bullet_ccd::reference
