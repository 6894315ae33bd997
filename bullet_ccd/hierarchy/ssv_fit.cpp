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

/// Surface of a box with these half-extents, swept by a ball. Steiner: S(K + r B) = S(K) +
/// 2 r M(K) + 4 pi r^2 with M = 2 pi (x + y + z) for a box.
double sweptSurface(const Vector3d& half, double radius)
{
    return 8.0 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0]) +
           4.0 * std::numbers::pi * radius * (half.sum() + radius);
}
}  // namespace

SsvNode boxNode(std::span<const SsvCorners> triangles, const SsvAxes& axes)
{
    // Extents are taken about a corner, so that rounding is relative to the size of the box, and
    // measured from the center as it is stored.
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

SsvNode sweptNode(std::span<const SsvCorners> triangles, const SsvAxes& axes, const SsvCore& core)
{
    // The radius is measured about the core as it is stored, to the nearest point of which only an
    // upper bound of the distance is needed.
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

double ssvSurface(const SsvNode& node)
{
    return sweptSurface(toDoubles(node.half), static_cast<double>(node.radius));
}

SsvNode roundedBox(std::span<const SsvCorners> triangles,
                   const SsvAxes& axes,
                   std::vector<Vector3d>& offsets)
{
    const SsvNode box = boxNode(triangles, axes);
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
        sweptNode(triangles, axes, {.center = toAxes * center, .half = bestHalf});
    return ssvSurface(rounded) < ssvSurface(box) ? rounded : box;
}
}  // namespace bullet_ccd
