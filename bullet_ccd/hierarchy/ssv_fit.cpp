#include "bullet_ccd/hierarchy/ssv_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Smallest float that is not below `x`; not inlined for the reason told at toFloats().
[[gnu::noinline]] float roundUp(double x)
{
    const float f = static_cast<float>(x);
    return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity())
                                      : f;
}

Vector3d toDoubles(const float (&x)[3])
{
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

// ------------------------------------------------------------------------------------------ cores

/// Center and half-extents of a core, in coordinates along the axes.
struct Core
{
    Vector3d center = Vector3d::Zero();
    Vector3d half = Vector3d::Zero();
};

using Points = std::span<const Vector3d>;

/// Middle and half the size of the bounds of the points.
Core boxCore(Points points)
{
    Vector3d low = points[0];
    Vector3d high = points[0];
    for (const Vector3d& p : points)
    {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    return {.center = 0.5 * (low + high), .half = 0.5 * (high - low)};
}

/// Ritter's ball: through two points far apart, grown by one pass over all points. `weight` 0
/// leaves a coordinate out.
Vector3d ballCenter(Points points, const Vector3d& weight)
{
    const auto distance = [&](const Vector3d& a, const Vector3d& b)
    { return weight.cwiseProduct(a - b).norm(); };
    const auto farthestFrom = [&](const Vector3d& from)
    {
        return *std::max_element(points.begin(),
                                 points.end(),
                                 [&](const Vector3d& a, const Vector3d& b)
                                 { return distance(a, from) < distance(b, from); });
    };
    const Vector3d a = farthestFrom(points[0]);
    const Vector3d b = farthestFrom(a);
    Vector3d center = 0.5 * (a + b);
    double radius = 0.5 * distance(a, b);
    for (const Vector3d& p : points)
    {
        const double d = distance(p, center);
        if (d > radius)
        {
            center += 0.5 * (1.0 - radius / d) * (p - center);
            radius = 0.5 * (radius + d);
        }
    }
    return center;
}

/// Along axis k the core must come so near to every point that the ball reaches it, if its other
/// coordinates are met by the core except for those of `weight`.
void fitAlong(int k, Points points, const Vector3d& weight, double radius, Core& core)
{
    double low = kInfinity;
    double high = -kInfinity;
    for (const Vector3d& p : points)
    {
        const double offSquared = weight.cwiseProduct(p - core.center).squaredNorm();
        const double reach = std::sqrt(std::max(radius * radius - offSquared, 0.0));
        low = std::min(low, p[k] + reach);
        high = std::max(high, p[k] - reach);
    }
    core.center[k] = 0.5 * (low + high);
    core.half[k] = std::max(0.5 * (high - low), 0.0);
}

Core lineCore(Points points)
{
    const Vector3d across(0.0, 1.0, 1.0);
    Core core;
    core.center = ballCenter(points, across);
    double radius = 0.0;
    for (const Vector3d& p : points)
    {
        radius = std::max(radius, across.cwiseProduct(p - core.center).norm());
    }
    fitAlong(0, points, across, radius, core);
    return core;
}

/// The radius is half the thickness. Points outside along both axes of the rectangle push the
/// corner next to them outwards along its diagonal.
Core rectangleCore(Points points)
{
    Core core = boxCore(points);
    const double radius = core.half[2];
    core.half[2] = 0.0;
    fitAlong(0, points, Vector3d::UnitZ(), radius, core);
    fitAlong(1, points, Vector3d::UnitZ(), radius, core);
    double growth[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
    for (const Vector3d& p : points)
    {
        const Vector3d d = p - core.center;
        const double x = std::abs(d.x()) - core.half.x();
        const double y = std::abs(d.y()) - core.half.y();
        if (x > 0.0 && y > 0.0)
        {
            const double along = (x + y) / std::numbers::sqrt2;
            const double offSquared = 0.5 * (x - y) * (x - y) + d.z() * d.z();
            double& corner = growth[d.x() > 0.0][d.y() > 0.0];
            corner =
                std::max(corner, along - std::sqrt(std::max(radius * radius - offSquared, 0.0)));
        }
    }
    for (int k = 0; k < 2; ++k)
    {
        const double low =
            k == 0 ? std::max(growth[0][0], growth[0][1]) : std::max(growth[0][0], growth[1][0]);
        const double high =
            k == 0 ? std::max(growth[1][0], growth[1][1]) : std::max(growth[0][1], growth[1][1]);
        core.center[k] += 0.5 * (high - low) / std::numbers::sqrt2;
        core.half[k] += 0.5 * (high + low) / std::numbers::sqrt2;
    }
    return core;
}

// ----------------------------------------------------------------------------------------- nodes

SsvNode storeNode(const SsvAxes& axes, const Vector3f& center, const Vector3d& half, double radius)
{
    SsvNode node{};
    for (int k = 0; k < 3; ++k)
    {
        node.center[k] = center[k];
        node.axis0[k] = axes.axis0[k];
        node.axis1[k] = axes.axis1[k];
        node.half[k] = roundUp(half[k]);
    }
    node.radius = roundUp(radius);
    node.coreRadius = roundUp(half.norm() * (1.0 + 1e-6));
    return node;
}

/// The box with the given axes. Extents are taken about a corner, so that rounding is relative to
/// the size of the box, and measured from the center as it is stored.
SsvNode storeBox(std::span<const SsvCorners> triangles, const SsvAxes& axes)
{
    const Matrix3d e = axes.matrix();
    const Matrix3d toAxes = e.transpose();
    const Vector3d about = triangles[0][0];
    Vector3d low = Vector3d::Zero();
    Vector3d high = Vector3d::Zero();
    for (const SsvCorners& corners : triangles)
    {
        for (const Vector3d& corner : corners)
        {
            const Vector3d s = toAxes * (corner - about);
            low = low.cwiseMin(s);
            high = high.cwiseMax(s);
        }
    }
    const Vector3f center = toFloats(about + e * (0.5 * (low + high)));
    const Vector3d middle = toAxes * (center.cast<double>() - about);
    Vector3d half = (high - middle).cwiseMax(middle - low);
    // The projections on axes that are orthonormal to 1e-7 only differ from the coordinates by that
    // fraction of the distance: 1e-6 covers it.
    half.array() += 1e-6 * half.norm();
    return storeNode(axes, center, half, 0.0);
}

/// Center and half-extents are a proposal; the radius is measured about the core as it is stored,
/// to the nearest point of which only an upper bound of the distance is needed.
SsvNode storeSwept(std::span<const SsvCorners> triangles, const SsvAxes& axes, const Core& core)
{
    const Matrix3d e = axes.matrix();
    SsvNode node = storeNode(axes, toFloats(e * core.center), core.half, 0.0);
    const Vector3d center = toDoubles(node.center);
    const Vector3d half = toDoubles(node.half);
    double radiusSquared = 0.0;
    for (const SsvCorners& corners : triangles)
    {
        for (const Vector3d& corner : corners)
        {
            const Vector3d d = corner - center;
            const Vector3d s = (e.transpose() * d).cwiseMax(-half).cwiseMin(half);
            radiusSquared = std::max(radiusSquared, (d - e * s).squaredNorm());
        }
    }
    // A few roundings of double precision, which the single one may not cover.
    node.radius =
        roundUp(std::sqrt(radiusSquared) * (1.0 + 1e-14) + 1e-15 * (center.norm() + half.norm()));
    return node;
}

/// Surface of a box with these half-extents, swept by a ball. Steiner: S(K + r B) = S(K) +
/// 2 r M(K) + 4 pi r^2 with M = 2 pi (x + y + z) for a box.
double sweptSurface(const Vector3d& half, double radius)
{
    return 8.0 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0]) +
           4.0 * std::numbers::pi * radius * (half.sum() + radius);
}

/// The box, or a smaller one inside it with the ball that it needs, if that has less surface. How
/// much smaller is chosen by a sample of the corners.
SsvNode roundedBox(std::span<const SsvCorners> triangles,
                   const SsvAxes& axes,
                   std::vector<Vector3d>& offsets)
{
    const SsvNode box = storeBox(triangles, axes);
    constexpr float kFlat = 0.02F;
    if (box.half[2] < kFlat * box.half[1])
    {
        return box;  // too little to gain
    }
    const Matrix3d toAxes = axes.matrix().transpose();
    const Vector3d center = toDoubles(box.center);
    const Vector3d half = toDoubles(box.half);
    constexpr std::size_t kSample = 48;
    const std::size_t stride = (triangles.size() + kSample - 1) / kSample;
    offsets.clear();
    for (std::size_t i = 0; i < triangles.size(); i += stride)
    {
        for (const Vector3d& corner : triangles[i])
        {
            offsets.emplace_back((toAxes * (corner - center)).cwiseAbs());
        }
    }
    constexpr int kSteps = 4;
    Vector3d bestHalf = half;
    double bestSurface = sweptSurface(half, 0.0);
    for (int i = 1; i <= kSteps; ++i)
    {
        const Vector3d core = (half.array() - half[2] * i / kSteps).cwiseMax(0.0).matrix();
        double radiusSquared = 0.0;
        for (const Vector3d& offset : offsets)
        {
            radiusSquared = std::max(radiusSquared, (offset - core).cwiseMax(0.0).squaredNorm());
        }
        const double surface = sweptSurface(core, std::sqrt(radiusSquared));
        if (surface < bestSurface)
        {
            bestSurface = surface;
            bestHalf = core;
        }
    }
    if (bestHalf == half)
    {
        return box;
    }
    const SsvNode rounded =
        storeSwept(triangles, axes, {.center = toAxes * center, .half = bestHalf});
    return ssvSurface(rounded) < ssvSurface(box) ? rounded : box;
}

/// Swept point, line or rectangle; `points` are the corners along the axes.
SsvNode sweptVolume(std::span<const SsvCorners> triangles,
                    const SsvAxes& axes,
                    SsvKind kind,
                    Points points)
{
    if (kind == SsvKind::SweptPoint)
    {
        const Vector3d center = ballCenter(points, Vector3d::Ones());
        return storeSwept(triangles, axes, {.center = center, .half = Vector3d::Zero()});
    }
    return storeSwept(
        triangles, axes, kind == SsvKind::SweptLine ? lineCore(points) : rectangleCore(points));
}

/// The simplest volume that is not much larger than the best.
SsvNode cheapestVolume(std::span<const SsvCorners> triangles,
                       const SsvAxes& axes,
                       const SsvNode& roundedBox,
                       Points points)
{
    constexpr std::array kSimplestFirst = {
        SsvKind::SweptPoint, SsvKind::SweptLine, SsvKind::SweptRectangle};
    constexpr double kTolerance = 1.1;
    std::array<SsvNode, kSimplestFirst.size()> nodes;
    double best = ssvSurface(roundedBox);
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
        nodes[i] = sweptVolume(triangles, axes, kSimplestFirst[i], points);
        best = std::min(best, ssvSurface(nodes[i]));
    }
    for (const SsvNode& node : nodes)
    {
        if (ssvSurface(node) <= kTolerance * best)
        {
            return node;
        }
    }
    return roundedBox;
}
}  // namespace

double ssvSurface(const SsvNode& node)
{
    return sweptSurface(toDoubles(node.half), static_cast<double>(node.radius));
}

SsvNode fitSsv(std::span<const SsvCorners> triangles, SsvKind kind, std::vector<Vector3d>& scratch)
{
    const SsvAxes axes = smallBoxAxes(triangles);
    if (kind == SsvKind::Box)
    {
        return storeBox(triangles, axes);
    }
    SsvNode rounded{};
    if (kind == SsvKind::RoundedBox || kind == SsvKind::Cheapest)
    {
        rounded = roundedBox(triangles, axes, scratch);
    }
    if (kind == SsvKind::RoundedBox)
    {
        return rounded;
    }
    const Matrix3d toAxes = axes.matrix().transpose();
    scratch.clear();
    for (const SsvCorners& corners : triangles)
    {
        for (const Vector3d& corner : corners)
        {
            scratch.emplace_back(toAxes * corner);
        }
    }
    return kind == SsvKind::Cheapest ? cheapestVolume(triangles, axes, rounded, scratch)
                                     : sweptVolume(triangles, axes, kind, scratch);
}
}  // namespace bullet_ccd
