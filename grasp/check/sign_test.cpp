#include "grasp/check/sign_test.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd::grasp
{
namespace
{
/// Half an ulp of 1. Differences, products and sums of the two determinants below err by at most
/// 3 and 7 of these, relative to the sum of the absolute products, and second-order terms: the
/// factors are rounded up generously.
constexpr double kRoundoff = std::numeric_limits<double>::epsilon() / 2.0;
constexpr double kBound2d = 4.0 * kRoundoff;
constexpr double kBound3d = 8.0 * kRoundoff;

int certainSign(double value, double bound)
{
    return value > bound ? 1 : (value < -bound ? -1 : 0);
}

/// Sides of a plane on which the corners of a triangle are.
using Sides = std::array<int, 3>;

Sides sidesOf(const Corners& triangle, const Corners& plane)
{
    const auto& [a, b, c] = plane;
    return {orient3d(a, b, c, triangle[0]),
            orient3d(a, b, c, triangle[1]),
            orient3d(a, b, c, triangle[2])};
}

/// True if all corners are certainly on one side.
bool onOneSide(const Sides& sides)
{
    return sides[0] != 0 && sides[0] == sides[1] && sides[0] == sides[2];
}

/// A segment of which the ends are on these sides of the triangle's plane.
Crossing segmentCrossing(const Eigen::Vector3d& p,
                         const Eigen::Vector3d& q,
                         int sideP,
                         int sideQ,
                         const Corners& triangle)
{
    if (sideP * sideQ > 0)
    {
        return Crossing::None;
    }
    const auto& [a, b, c] = triangle;
    const std::array<int, 3> turns = {
        orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)};
    const auto [low, high] = std::minmax_element(turns.begin(), turns.end());
    if (*low < 0 && *high > 0)
    {
        return Crossing::None;  // the line passes outside of the triangle
    }
    const bool open = sideP * sideQ == 0 || turns[0] * turns[1] * turns[2] == 0;
    return open ? Crossing::Touching : Crossing::Proper;
}

double pointSegmentDistance(const Eigen::Vector3d& point,
                            const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b)
{
    const Eigen::Vector3d edge = b - a;
    const double lengthSquared = edge.squaredNorm();
    const double place =
        lengthSquared > 0.0 ? std::clamp((point - a).dot(edge) / lengthSquared, 0.0, 1.0) : 0.0;
    return (point - a - place * edge).norm();
}
}  // namespace

int orient2d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    const double left = (a.x() - c.x()) * (b.y() - c.y());
    const double right = (a.y() - c.y()) * (b.x() - c.x());
    return certainSign(left - right, kBound2d * (std::abs(left) + std::abs(right)));
}

int orient3d(const Eigen::Vector3d& a,
             const Eigen::Vector3d& b,
             const Eigen::Vector3d& c,
             const Eigen::Vector3d& d)
{
    const Eigen::Vector3d u = a - d;
    const Eigen::Vector3d v = b - d;
    const Eigen::Vector3d w = c - d;
    // det[u v w], expanded along the z components.
    const double vw = v.x() * w.y();
    const double wv = w.x() * v.y();
    const double wu = w.x() * u.y();
    const double uw = u.x() * w.y();
    const double uv = u.x() * v.y();
    const double vu = v.x() * u.y();
    const double determinant = u.z() * (vw - wv) + v.z() * (wu - uw) + w.z() * (uv - vu);
    const double permanent = (std::abs(vw) + std::abs(wv)) * std::abs(u.z()) +
                             (std::abs(wu) + std::abs(uw)) * std::abs(v.z()) +
                             (std::abs(uv) + std::abs(vu)) * std::abs(w.z());
    return certainSign(determinant, kBound3d * permanent);
}

Crossing crossing(const Corners& triangleA, const Corners& triangleB)
{
    const Sides sidesA = sidesOf(triangleA, triangleB);
    if (onOneSide(sidesA))
    {
        return Crossing::None;
    }
    const Sides sidesB = sidesOf(triangleB, triangleA);
    if (onOneSide(sidesB))
    {
        return Crossing::None;
    }
    Crossing result = Crossing::None;
    for (std::size_t i = 0; i < 3 && result != Crossing::Proper; ++i)
    {
        const std::size_t j = (i + 1) % 3;
        result = std::max(
            {result,
             segmentCrossing(triangleA[i], triangleA[j], sidesA[i], sidesA[j], triangleB),
             segmentCrossing(triangleB[i], triangleB[j], sidesB[i], sidesB[j], triangleA)});
    }
    return result;
}

double pointTriangleDistance(const Eigen::Vector3d& point, const Corners& triangle)
{
    const auto& [a, b, c] = triangle;
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    // Inside the prism over the triangle the plane is nearest, elsewhere the rim.
    const bool inPrism = (b - a).cross(point - a).dot(normal) > 0.0 &&
                         (c - b).cross(point - b).dot(normal) > 0.0 &&
                         (a - c).cross(point - c).dot(normal) > 0.0;
    if (inPrism)
    {
        return std::abs((point - a).dot(normal.normalized()));
    }
    return std::min({pointSegmentDistance(point, a, b),
                     pointSegmentDistance(point, b, c),
                     pointSegmentDistance(point, c, a)});
}
}  // namespace bullet_ccd::grasp
