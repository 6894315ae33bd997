#include "benchmarks/rigid/volume_kinds.h"

#include "bullet_ccd/hierarchy/ssv_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Points = std::span<const Vector3d>;

/// Middle and half the size of the bounds of the points.
SsvCore boxCore(Points points)
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
void fitAlong(int k, Points points, const Vector3d& weight, double radius, SsvCore& core)
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

SsvCore lineCore(Points points)
{
    const Vector3d across(0.0, 1.0, 1.0);
    SsvCore core;
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
SsvCore rectangleCore(Points points)
{
    SsvCore core = boxCore(points);
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

/// The corners along the axes.
void placeAlong(std::span<const SsvCorners> triangles,
                const SsvAxes& axes,
                std::vector<Vector3d>& points)
{
    const Matrix3d toAxes = axes.matrix().transpose();
    points.clear();
    for (const SsvCorners& corners : triangles)
    {
        for (const Vector3d& corner : corners)
        {
            points.emplace_back(toAxes * corner);
        }
    }
}

using Scratch = std::vector<Vector3d>;

SsvNode box(std::span<const SsvCorners> triangles, const SsvAxes& axes, Scratch& /*unused*/)
{
    return boxNode(triangles, axes);
}

SsvNode sweptPoint(std::span<const SsvCorners> triangles, const SsvAxes& axes, Scratch& points)
{
    placeAlong(triangles, axes, points);
    return sweptNode(triangles, axes, {.center = ballCenter(points, Vector3d::Ones())});
}

SsvNode sweptLine(std::span<const SsvCorners> triangles, const SsvAxes& axes, Scratch& points)
{
    placeAlong(triangles, axes, points);
    return sweptNode(triangles, axes, lineCore(points));
}

SsvNode sweptRectangle(std::span<const SsvCorners> triangles, const SsvAxes& axes, Scratch& points)
{
    placeAlong(triangles, axes, points);
    return sweptNode(triangles, axes, rectangleCore(points));
}

/// The simplest volume that is not much larger than the best.
SsvNode cheapest(std::span<const SsvCorners> triangles, const SsvAxes& axes, Scratch& scratch)
{
    constexpr double kTolerance = 1.1;
    const std::array simplestFirst{sweptPoint(triangles, axes, scratch),
                                   sweptLine(triangles, axes, scratch),
                                   sweptRectangle(triangles, axes, scratch),
                                   roundedBox(triangles, axes, scratch)};
    double best = kInfinity;
    for (const SsvNode& node : simplestFirst)
    {
        best = std::min(best, ssvSurface(node));
    }
    return *std::ranges::find_if(
        simplestFirst, [&](const SsvNode& node) { return ssvSurface(node) <= kTolerance * best; });
}

SsvFit fitOf(VolumeKind kind)
{
    switch (kind)
    {
        case VolumeKind::Box:
            return {box};
        case VolumeKind::SweptRectangle:
            return {sweptRectangle};
        case VolumeKind::SweptLine:
            return {sweptLine};
        case VolumeKind::SweptPoint:
            return {sweptPoint};
        case VolumeKind::Cheapest:
            return {cheapest};
        case VolumeKind::RoundedBox:
            break;
    }
    return {roundedBox};
}
}  // namespace

SsvTree buildTreeOf(VolumeKind kind, TriangleMesh mesh)
{
    return buildSsvTree(std::move(mesh), fitOf(kind));
}
}  // namespace bullet_ccd::benchmarks
