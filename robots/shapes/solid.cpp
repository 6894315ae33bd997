#include "robots/shapes/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace bullet_ccd::shapes
{
namespace
{
constexpr double kDifference = 1e-5;  // [m]: far below every fillet, far above rounding

/// The pieces of a profile, ready for many distance queries.
class Polyline
{
public:
    explicit Polyline(const Profile& points)
    {
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
        {
            const Eigen::Vector2d along = points[i + 1] - points[i];
            if (along.squaredNorm() > 0.0)
            {
                m_pieces.push_back({points[i], along, 1.0 / along.squaredNorm()});
            }
        }
    }

    [[nodiscard]] double distance(const Eigen::Vector2d& p) const
    {
        double best = std::numeric_limits<double>::infinity();
        for (const Piece& piece : m_pieces)
        {
            const Eigen::Vector2d q = p - piece.start;
            const double t = std::clamp(q.dot(piece.along) * piece.inverse, 0.0, 1.0);
            best = std::min(best, (q - t * piece.along).squaredNorm());
        }
        return std::sqrt(best);
    }

private:
    struct Piece
    {
        Eigen::Vector2d start;
        Eigen::Vector2d along;
        double inverse = 0.0;  ///< 1 / |along|²
    };
    std::vector<Piece> m_pieces;
};

/// Whether a ray in +r from `p` crosses the profile an odd number of times.
bool isInsideProfile(const Profile& points, const Eigen::Vector2d& p)
{
    bool inside = false;
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
    {
        const Eigen::Vector2d& a = points[i];
        const Eigen::Vector2d& b = points[i + 1];
        if ((a.y() > p.y()) != (b.y() > p.y()))
        {
            const double t = (p.y() - a.y()) / (b.y() - a.y());
            inside ^= p.x() < a.x() + t * (b.x() - a.x());
        }
    }
    return inside;
}

Eigen::Vector2d halfPlane(const Eigen::Vector3d& p)
{
    return {std::sqrt(p.x() * p.x() + p.y() * p.y()), p.z()};
}

/// Polynomial smooth minimum: differs from the minimum only where |a - b| < 2 radius.
double smoothMin(double a, double b, double radius)
{
    const double width = 2.0 * radius;
    const double h = std::max(width - std::abs(a - b), 0.0);
    return std::min(a, b) - (radius > 0.0 ? h * h / (4.0 * width) : 0.0);
}

template <typename Point>
Point catmullRom(const Point& p0, const Point& p1, const Point& p2, const Point& p3, double t)
{
    return 0.5 * (2.0 * p1 + t * (p2 - p0) + t * t * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) +
                  t * t * t * (3.0 * p1 - p0 - 3.0 * p2 + p3));
}

/// Calls `add` with the points of the curve; `at(i)` is control point i as an Eigen vector.
template <typename At, typename Add>
void sampleCurve(std::size_t count, int steps, At at, Add add)
{
    for (std::size_t i = 0; i + 1 < count; ++i)
    {
        // Mirrored end points keep the end tangents.
        const auto p1 = at(i);
        const auto p2 = at(i + 1);
        const auto p0 = i > 0 ? at(i - 1) : decltype(p1)(2.0 * p1 - p2);
        const auto p3 = i + 2 < count ? at(i + 2) : decltype(p1)(2.0 * p2 - p1);
        for (int step = 0; step < steps; ++step)
        {
            add(catmullRom(p0, p1, p2, p3, static_cast<double>(step) / steps));
        }
    }
    add(at(count - 1));
}
}  // namespace

Solid ball(double radius)
{
    return [=](const Eigen::Vector3d& p) { return p.norm() - radius; };
}

Solid roundedBox(const Eigen::Vector3d& halfExtents, double rounding)
{
    const Eigen::Vector3d core = halfExtents - Eigen::Vector3d::Constant(rounding);
    return [=](const Eigen::Vector3d& p)
    {
        const Eigen::Vector3d q = p.cwiseAbs() - core;
        return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - rounding;
    };
}

Solid roundedCylinder(double radius, double low, double high, double rounding)
{
    const double middle = 0.5 * (low + high);
    const Eigen::Vector2d core(radius - rounding, 0.5 * (high - low) - rounding);
    return [=](const Eigen::Vector3d& p)
    {
        const Eigen::Vector2d q =
            Eigen::Vector2d(std::sqrt(p.x() * p.x() + p.y() * p.y()), std::abs(p.z() - middle)) -
            core;
        return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - rounding;
    };
}

Solid lathe(const Profile& profile, double growth)
{
    return [=, polyline = Polyline(profile)](const Eigen::Vector3d& p)
    {
        const Eigen::Vector2d q = halfPlane(p);
        const double distance = polyline.distance(q);
        return (isInsideProfile(profile, q) ? -distance : distance) - growth;
    };
}

Solid latheShell(const Profile& profile, double thickness)
{
    return [polyline = Polyline(profile), thickness](const Eigen::Vector3d& p)
    { return polyline.distance(halfPlane(p)) - 0.5 * thickness; };
}

Solid tube(const std::vector<TubePoint>& points)
{
    return [=](const Eigen::Vector3d& p)
    {
        double best = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
        {
            const Eigen::Vector3d ab = points[i + 1].position - points[i].position;
            const Eigen::Vector3d ap = p - points[i].position;
            const double t = std::clamp(ap.dot(ab) / ab.squaredNorm(), 0.0, 1.0);
            const double radius = points[i].radius + t * (points[i + 1].radius - points[i].radius);
            best = std::min(best, (ap - t * ab).norm() - radius);
        }
        return best;
    };
}

Solid unite(const Solid& a, const Solid& b)
{
    return [=](const Eigen::Vector3d& p) { return std::min(a(p), b(p)); };
}

Solid cut(const Solid& from, const Solid& what)
{
    return [=](const Eigen::Vector3d& p) { return std::max(from(p), -what(p)); };
}

Solid blend(const Solid& a, const Solid& b, double radius)
{
    return [=](const Eigen::Vector3d& p) { return smoothMin(a(p), b(p), radius); };
}

Solid blendCut(const Solid& from, const Solid& what, double radius)
{
    return [=](const Eigen::Vector3d& p) { return -smoothMin(-from(p), what(p), radius); };
}

Solid blendIntersect(const Solid& a, const Solid& b, double radius)
{
    return [=](const Eigen::Vector3d& p) { return -smoothMin(-a(p), -b(p), radius); };
}

Solid placed(const Solid& solid, const Eigen::Isometry3d& X)
{
    const Eigen::Isometry3d inverse = X.inverse();
    return [=](const Eigen::Vector3d& p) { return solid(inverse * p); };
}

Solid moved(const Solid& solid, const Eigen::Vector3d& by)
{
    return [=](const Eigen::Vector3d& p) { return solid(p - by); };
}

Solid stretched(const Solid& solid, const Eigen::Vector3d& factors)
{
    const double least = factors.minCoeff();  // keeps the slope at most 1
    return [=](const Eigen::Vector3d& p) { return least * solid(p.cwiseQuotient(factors)); };
}

Solid warped(const Solid& solid,
             const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& warp,
             double steepness)
{
    return [=](const Eigen::Vector3d& p) { return solid(warp(p)) / steepness; };
}

Profile smoothCurve(const Profile& points, int steps)
{
    Profile curve;
    sampleCurve(
        points.size(),
        steps,
        [&](std::size_t i) { return points[i]; },
        [&](const Eigen::Vector2d& p) { curve.push_back(p); });
    return curve;
}

std::vector<TubePoint> smoothCurve(const std::vector<TubePoint>& points, int steps)
{
    std::vector<TubePoint> curve;
    sampleCurve(
        points.size(),
        steps,
        [&](std::size_t i)
        {
            Eigen::Vector4d p;
            p << points[i].position, points[i].radius;
            return p;
        },
        [&](const Eigen::Vector4d& p) {
            curve.push_back({p.head<3>(), p.w()});
        });
    return curve;
}

Eigen::Vector3d gradientAt(const Solid& solid, const Eigen::Vector3d& point)
{
    // The corners of a tetrahedron: four evaluations give what six along the axes would.
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& corner : {Eigen::Vector3d(1, 1, 1),
                                          Eigen::Vector3d(1, -1, -1),
                                          Eigen::Vector3d(-1, 1, -1),
                                          Eigen::Vector3d(-1, -1, 1)})
    {
        gradient += solid(point + kDifference * corner) * corner;
    }
    return gradient / (4.0 * kDifference);
}
}  // namespace bullet_ccd::shapes
