#include "bullet_ccd/convex/box_separation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
namespace
{
/// The direction that belongs to the features, towards B: A lies at p from B.
Eigen::Vector3d normalOf(const Placement& pose, int edgeA, int edgeB)
{
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    if (edgeB < 0)
    {
        normal = pose.R.col(edgeA);
    }
    else if (edgeA < 0)
    {
        normal[edgeB] = 1.0;
    }
    else
    {
        // The cross product of an axis of A and a unit vector.
        const int k = (edgeB + 1) % 3;
        const int m = (edgeB + 2) % 3;
        const double x = pose.R(m, edgeA);
        const double y = -pose.R(k, edgeA);
        const double length = std::sqrt(x * x + y * y);
        normal[k] = x / length;
        normal[m] = y / length;
    }
    const double sign = normal.dot(pose.p) > 0.0 ? -1.0 : 1.0;
    return sign * normal;
}
}  // namespace

BoxAxis bestBoxAxis(const Eigen::Vector3d& halfA,
                    const Eigen::Vector3d& halfB,
                    const Placement& pose)
{
    // Which axis is best is as good as random, so branches would be guessed wrongly: all gaps come
    // first, as squares that keep the sign. The root is taken of the best only.
    const Eigen::Matrix3d& R = pose.R;
    const Eigen::Matrix3d size = R.cwiseAbs();
    const Eigen::Vector3d pA = R.transpose() * pose.p;  // along the axes of A
    const Eigen::Vector3d gapsA = pA.cwiseAbs() - halfA - size.transpose() * halfB;
    const Eigen::Vector3d gapsB = pose.p.cwiseAbs() - halfB - size * halfA;
    constexpr std::size_t kAxes = 15;
    std::array<double, kAxes> squares{};
    for (int i = 0; i < 3; ++i)
    {
        const auto k = static_cast<std::size_t>(i);
        squares[k] = gapsA[i] * std::abs(gapsA[i]);
        squares[3 + k] = gapsB[i] * std::abs(gapsB[i]);
    }
    // Edges i of A and j of B: the direction is a_i x b_j, of length sqrt(1 - R_ji^2); in the frame
    // of B, a_i is column i of R. Its height over the corners takes one entry of |R| each. It
    // counts only where it separates.
    constexpr double kParallel = 1e-10;
    constexpr double kNever = -std::numeric_limits<double>::infinity();
    std::size_t axis = 6;
    for (int i = 0; i < 3; ++i)
    {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j)
        {
            const int j1 = (j + 1) % 3;
            const int j2 = (j + 2) % 3;
            const double apart = std::abs(pose.p[j1] * R(j2, i) - pose.p[j2] * R(j1, i));
            const double reach = halfA[i1] * size(j, i2) + halfA[i2] * size(j, i1) +
                                 halfB[j1] * size(j2, i) + halfB[j2] * size(j1, i);
            const double square = R(j1, i) * R(j1, i) + R(j2, i) * R(j2, i);
            const double gap = apart - reach;
            const double height = gap * gap / std::max(square, kParallel);
            const bool counts =
                (static_cast<int>(gap > 0.0) & static_cast<int>(square > kParallel)) != 0;
            squares[axis++] = counts ? height : kNever;
        }
    }
    double most = squares[0];
    for (const double square : squares)
    {
        most = std::max(most, square);
    }
    unsigned isBest = 1U << kAxes;  // where numbers overflow, none is
    for (std::size_t k = 0; k < kAxes; ++k)
    {
        isBest |= static_cast<unsigned>(squares[k] == most) << k;
    }
    const int first = std::countr_zero(isBest) % static_cast<int>(kAxes);
    BoxAxis best{.gap = std::copysign(std::sqrt(std::abs(most)), most)};
    if (first < 6)
    {
        best.edgeA = first < 3 ? first : -1;
        best.edgeB = first < 3 ? -1 : first - 3;
    }
    else
    {
        best.edgeA = (first - 6) / 3;
        best.edgeB = (first - 6) % 3;
    }
    best.normal = normalOf(pose, best.edgeA, best.edgeB);
    return best;
}

bool refreshAxis(const Eigen::Vector3d& halfA,
                 const Eigen::Vector3d& halfB,
                 const Placement& pose,
                 BoxAxis& axis)
{
    axis.normal = normalOf(pose, axis.edgeA, axis.edgeB);
    axis.gap = -axis.normal.dot(pose.p) - halfA.dot((pose.R.transpose() * axis.normal).cwiseAbs()) -
               halfB.dot(axis.normal.cwiseAbs());
    return axis.gap > 0.0;
}

bool facingPoints(const Eigen::Vector3d& halfA,
                  const Eigen::Vector3d& halfB,
                  const Placement& pose,
                  const BoxAxis& axis,
                  ClosestPoints& points)
{
    using Eigen::Vector3d;
    const Vector3d& n = axis.normal;
    const auto corner = [](const Vector3d& half, const Vector3d& direction) -> Vector3d
    {
        return {std::copysign(half.x(), direction.x()),
                std::copysign(half.y(), direction.y()),
                std::copysign(half.z(), direction.z())};
    };
    const auto isInside = [](const Vector3d& x, const Vector3d& half, int across)
    {
        const int k = (across + 1) % 3;
        const int m = (across + 2) % 3;
        return (static_cast<int>(std::abs(x[k]) <= half[k]) &
                static_cast<int>(std::abs(x[m]) <= half[m])) != 0;
    };
    Vector3d inA = corner(halfA, pose.R.transpose() * n);
    Vector3d inB = corner(halfB, -n);
    points.normal = n;
    points.distance = points.gap = axis.gap;
    if (axis.edgeA < 0)
    {
        points.pointA = pose.R * inA + pose.p;
        points.pointB = points.pointA + axis.gap * n;
        return isInside(points.pointA, halfB, axis.edgeB);
    }
    if (axis.edgeB < 0)
    {
        points.pointB = inB;
        points.pointA = inB - axis.gap * n;
        return isInside(pose.R.transpose() * (points.pointA - pose.p), halfA, axis.edgeA);
    }
    inA[axis.edgeA] = 0.0;
    inB[axis.edgeB] = 0.0;
    const Vector3d a = pose.R.col(axis.edgeA);
    const Vector3d middleA = pose.R * inA + pose.p;
    const Vector3d between = inB - middleA;
    const double alongA = between.dot(a);
    const double alongB = between[axis.edgeB];
    const double cosine = a[axis.edgeB];
    const double square = 1.0 - cosine * cosine;
    const double s = (alongA - cosine * alongB) / square;
    const double u = (cosine * alongA - alongB) / square;
    points.pointA = middleA + s * a;
    points.pointB = inB;
    points.pointB[axis.edgeB] = u;
    return std::abs(s) <= halfA[axis.edgeA] && std::abs(u) <= halfB[axis.edgeB];
}
}  // namespace bullet_ccd
