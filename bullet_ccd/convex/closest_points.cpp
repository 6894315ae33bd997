#include "bullet_ccd/convex/closest_points.h"

#include "bullet_ccd/convex/support.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

/// The point of a simplex that is closest to the origin: sum_i weight_i corner_i over `size`
/// corners, the `index`-th of the simplex.
struct Nearest
{
    Vector3d point = Vector3d::Zero();
    std::array<double, 4> weight{};
    std::array<int, 4> index{};
    int size = 0;
};

using Corners = std::array<Vector3d, 4>;

Nearest nearestOfPoint(const Corners& y, int i)
{
    return {.point = y[static_cast<std::size_t>(i)], .weight = {1.0}, .index = {i}, .size = 1};
}

Nearest nearestOfSegment(const Corners& y, int i, int j)
{
    const Vector3d& a = y[static_cast<std::size_t>(i)];
    const Vector3d ab = y[static_cast<std::size_t>(j)] - a;
    const double along = -a.dot(ab);
    const double length = ab.squaredNorm();
    if (!(along > 0.0))
    {
        return nearestOfPoint(y, i);
    }
    if (!(along < length))
    {
        return nearestOfPoint(y, j);
    }
    const double s = along / length;
    // Perpendicular to the segment up to rounding of the point itself, however near the origin is.
    const Vector3d point = a + s * ab;
    return {.point = point - (ab.dot(point) / length) * ab,
            .weight = {1.0 - s, s},
            .index = {i, j},
            .size = 2};
}

const Nearest& nearer(const Nearest& p, const Nearest& q)
{
    return q.point.squaredNorm() < p.point.squaredNorm() ? q : p;
}

/// If the origin lies above the triangle, its foot; else the nearest point of the edges.
Nearest nearestOfTriangle(const Corners& y, int i, int j, int k)
{
    const Vector3d& a = y[static_cast<std::size_t>(i)];
    const Vector3d& b = y[static_cast<std::size_t>(j)];
    const Vector3d& c = y[static_cast<std::size_t>(k)];
    const Vector3d normal = (b - a).cross(c - a);
    const double u = normal.dot(b.cross(c));
    const double v = normal.dot(c.cross(a));
    const double w = normal.dot(a.cross(b));
    const double square = normal.squaredNorm();
    if (u > 0.0 && v > 0.0 && w > 0.0 && square > 0.0)
    {
        // Not the sum of the corners: near the plane that would leave rounding only.
        return {.point = normal * (normal.dot(a) / square),
                .weight = {u / (u + v + w), v / (u + v + w), w / (u + v + w)},
                .index = {i, j, k},
                .size = 3};
    }
    Nearest best = nearestOfSegment(y, i, j);
    best = nearer(best, nearestOfSegment(y, i, k));
    return nearer(best, nearestOfSegment(y, j, k));
}

/// A point of zero with four corners if the origin is inside.
/// @param isOutside the origin is known not to be inside
Nearest nearestOfTetrahedron(const Corners& y, bool isOutside)
{
    constexpr std::array<std::array<int, 4>, 4> kFaces{
        {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}}};
    Nearest best{.index = {0, 1, 2, 3}, .size = 4};
    double least = std::numeric_limits<double>::infinity();
    for (const std::array<int, 4>& f : kFaces)
    {
        const Vector3d& a = y[static_cast<std::size_t>(f[0])];
        const Vector3d normal =
            (y[static_cast<std::size_t>(f[1])] - a).cross(y[static_cast<std::size_t>(f[2])] - a);
        const double inside = normal.dot(y[static_cast<std::size_t>(f[3])] - a);
        const double origin = -normal.dot(a);
        // A flat tetrahedron has no inside: the origin is nearest to one of its faces.
        if (!isOutside && inside * origin > 0.0)
        {
            continue;
        }
        const Nearest face = nearestOfTriangle(y, f[0], f[1], f[2]);
        if (face.point.squaredNorm() < least)
        {
            least = face.point.squaredNorm();
            best = face;
        }
    }
    return best;
}

Nearest nearestOf(const Corners& y, int size, bool isOutside)
{
    switch (size)
    {
        case 1:
            return nearestOfPoint(y, 0);
        case 2:
            return nearestOfSegment(y, 0, 1);
        case 3:
            return nearestOfTriangle(y, 0, 1, 2);
        default:
            return nearestOfTetrahedron(y, isOutside);
    }
}

/// Keeps what carries the nearest point.
void reduce(Simplex& simplex, Corners& y, const Nearest& nearest)
{
    const Simplex old = simplex;
    const Corners oldY = y;
    simplex.size = nearest.size;
    for (std::size_t n = 0; n < static_cast<std::size_t>(nearest.size); ++n)
    {
        const auto i = static_cast<std::size_t>(nearest.index[n]);
        simplex.a[n] = old.a[i];
        simplex.b[n] = old.b[i];
        y[n] = oldY[i];
    }
}

/// Weights of a thin triangle have few digits right. What they leave is known better, and so is the
/// change that makes it vanish.
void refineWeights(const Corners& y, Nearest& nearest)
{
    if (nearest.size != 3)
    {
        return;
    }
    const Vector3d ab = y[1] - y[0];
    const Vector3d ac = y[2] - y[0];
    const Vector3d normal = ab.cross(ac);
    const Vector3d left = y[0] + nearest.weight[1] * ab + nearest.weight[2] * ac - nearest.point;
    const double square = normal.squaredNorm();
    const double b = nearest.weight[1] - normal.dot(left.cross(ac)) / square;
    const double c = nearest.weight[2] - normal.dot(ab.cross(left)) / square;
    nearest.weight[1] = std::clamp(b, 0.0, 1.0);
    nearest.weight[2] = std::clamp(c, 0.0, 1.0 - nearest.weight[1]);
    nearest.weight[0] = 1.0 - nearest.weight[1] - nearest.weight[2];
}

/// The points of the two cores that a simplex, reduced to what carries them, has nearest.
std::pair<Vector3d, Vector3d> pointsOf(const Nearest& nearest,
                                       const Simplex& simplex,
                                       const Placement& pose)
{
    Vector3d pointA = Vector3d::Zero();
    Vector3d pointB = Vector3d::Zero();
    for (std::size_t n = 0; n < static_cast<std::size_t>(nearest.size); ++n)
    {
        const double weight = nearest.size == 4 ? 0.25 : nearest.weight[n];
        pointA += weight * (pose.R * simplex.a[n] + pose.p);
        pointB += weight * simplex.b[n];
    }
    return {pointA, pointB};
}
}  // namespace

ClosestPoints closestPoints(const ConvexShape& coreA,
                            const ConvexShape& coreB,
                            const Placement& pose,
                            double enough,
                            bool apart,
                            Simplex& simplex)
{
    Corners y;
    const auto corner = [&](std::size_t i) -> Vector3d
    { return pose.R * simplex.a[i] + pose.p - simplex.b[i]; };
    if (simplex.size == 0)
    {
        const Vector3d direction = pose.p.isZero(0.0) ? Vector3d(Vector3d::UnitX()) : pose.p;
        simplex.a[0] = supportPoint(coreA, -(pose.R.transpose() * direction));
        simplex.b[0] = supportPoint(coreB, direction);
        simplex.size = 1;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex.size); ++i)
    {
        y[i] = corner(i);
    }

    ClosestPoints best;
    best.gap = -std::numeric_limits<double>::infinity();
    best.distance = std::numeric_limits<double>::infinity();
    double least = std::numeric_limits<double>::infinity();
    bool isTighter = true;  // than before: the gap of the last direction
    constexpr int kMostSteps = 64;
    for (int step = 0; step < kMostSteps; ++step)
    {
        // Where a direction separates the cores, rounding alone puts the origin inside.
        Nearest nearest = nearestOf(y, simplex.size, apart || best.gap > 0.0);
        reduce(simplex, y, nearest);
        refineWeights(y, nearest);
        const auto [pointA, pointB] = pointsOf(nearest, simplex, pose);
        const double length = nearest.point.norm();
        if (!(length > 0.0) && !apart)
        {
            return {.pointA = pointA, .pointB = pointB};
        }
        if (!(length > 0.0 && (length < least || isTighter)))
        {
            return best;  // rounding is all that is left
        }
        least = std::min(least, length);
        // Of the points themselves: what the simplex says of a short distance may be too small.
        const double distance = (pointB - pointA).norm();
        if (distance < best.distance)
        {
            best.pointA = pointA;
            best.pointB = pointB;
            best.distance = distance;
        }
        const Vector3d normal = -nearest.point / length;
        const auto next = static_cast<std::size_t>(simplex.size);
        simplex.a[next] = supportPoint(coreA, pose.R.transpose() * normal);
        simplex.b[next] = supportPoint(coreB, -normal);
        y[next] = corner(next);
        const double gap = -normal.dot(y[next]);
        isTighter = gap > best.gap;
        if (isTighter)
        {
            best.gap = gap;
            best.normal = normal;
        }
        constexpr double kClose = 1e-12;
        constexpr double kMost = 0.9;
        if (best.gap >= (1.0 - kClose) * best.distance ||
            (best.gap > enough && best.gap > kMost * best.distance))
        {
            return best;
        }
        simplex.size += 1;
    }
    simplex.size = std::min(simplex.size, 3);
    return best;
}
}  // namespace bullet_ccd
