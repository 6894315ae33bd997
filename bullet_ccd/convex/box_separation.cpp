#include "bullet_ccd/convex/box_separation.h"

#include "bullet_ccd/convex/turn.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
namespace
{
/// Three numbers and one that fills the last pair, computed with two at a time.
struct Three
{
    TwoNumbers low;
    TwoNumbers high;

    Three(double x, double y, double z) : low{x, y}, high{z, 0.0} {}
    Three(TwoNumbers xy, TwoNumbers z) : low(xy), high(z) {}

    friend Three operator+(Three a, Three b) { return {a.low + b.low, a.high + b.high}; }
    friend Three operator-(Three a, Three b) { return {a.low - b.low, a.high - b.high}; }
    friend Three operator*(Three a, Three b) { return {a.low * b.low, a.high * b.high}; }
    friend Three operator/(Three a, Three b) { return {a.low / b.low, a.high / b.high}; }
    friend Three operator*(double k, Three a) { return {k * a.low, k * a.high}; }
    [[nodiscard]] Three larger(Three b) const
    {
        return {low > b.low ? low : b.low, high > b.high ? high : b.high};
    }
    /// Zero where `of` is not above the limit.
    [[nodiscard]] Three where(Three of, double limit) const
    {
        const TwoNumbers zero{0.0, 0.0};
        return {of.low > limit ? low : zero, of.high > limit ? high : zero};
    }
    [[nodiscard]] Three abs() const { return larger({-low, -high}); }
    [[nodiscard]] double sum() const { return low[0] + low[1] + high[0]; }
    [[nodiscard]] double largest() const { return std::max(std::max(low[0], low[1]), high[0]); }
};

/// The direction that belongs to the features, towards B: A lies at p from B.
Eigen::Vector3d normalOf(const Placement& pose, int edgeA, int edgeB)
{
    const Eigen::Vector3d unit(
        edgeB == 0 ? 1.0 : 0.0, edgeB == 1 ? 1.0 : 0.0, edgeB == 2 ? 1.0 : 0.0);
    if (edgeA < 0)
    {
        return pose.p[edgeB] > 0.0 ? Eigen::Vector3d(-unit) : unit;
    }
    Eigen::Vector3d normal = pose.R.col(edgeA);
    double length = 1.0;
    if (edgeB >= 0)
    {
        normal = normal.cross(unit);
        length = normal.norm();
    }
    return normal * (normal.dot(pose.p) > 0.0 ? -1.0 / length : 1.0 / length);
}
}  // namespace

BoxAxis bestBoxAxis(const Eigen::Vector3d& halfA,
                    const Eigen::Vector3d& halfB,
                    const Placement& pose)
{
    // Which axis is best is as good as random, so branches would be guessed wrongly: all gaps come
    // first, two numbers at once, and the root is taken of the best only.
    const Eigen::Matrix3d& R = pose.R;
    // Column `column` from row `row` on, round again.
    const auto from = [&R](int row, int column) -> Three {
        return {R(row, column), R((row + 1) % 3, column), R((row + 2) % 3, column)};
    };
    const Three size[3] = {from(0, 0).abs(), from(0, 1).abs(), from(0, 2).abs()};
    const Three p(pose.p[0], pose.p[1], pose.p[2]);
    const Three p1(pose.p[1], pose.p[2], pose.p[0]);
    const Three p2(pose.p[2], pose.p[0], pose.p[1]);
    const Three halfB1(halfB[1], halfB[2], halfB[0]);
    const Three halfB2(halfB[2], halfB[0], halfB[1]);

    const Three half(halfB[0], halfB[1], halfB[2]);
    const Three gapsB =
        p.abs() - half - halfA[0] * size[0] - halfA[1] * size[1] - halfA[2] * size[2];
    // Where numbers overflow, no comparison holds: the first face is as good as any.
    BoxAxis best{.gap = -std::numeric_limits<double>::infinity(), .edgeA = 0};
    for (int i = 0; i < 3; ++i)
    {
        const double gapA = std::abs((from(0, i) * p).sum()) - halfA[i] - (size[i] * half).sum();
        best.edgeA = gapA > best.gap ? i : best.edgeA;
        best.gap = std::max(best.gap, gapA);
    }
    for (int j = 0; j < 3; ++j)
    {
        const double gapB = j < 2 ? gapsB.low[j] : gapsB.high[0];
        best.edgeA = gapB > best.gap ? -1 : best.edgeA;
        best.edgeB = gapB > best.gap ? j : best.edgeB;
        best.gap = std::max(best.gap, gapB);
    }

    // Edges i of A and j of B: the direction is a_i x b_j, of length sqrt(1 - R_ji^2); in the frame
    // of B, a_i is column i of R. Its height over the corners takes one entry of |R| each. It
    // counts only where it separates and the edges are not parallel.
    constexpr double kParallel = 1e-10;
    std::array<std::array<double, 3>, 3> squares{};
    double most = 0.0;
    for (int i = 0; i < 3; ++i)
    {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        const Three next = from(1, i);
        const Three last = from(2, i);
        const Three apart = p1 * last - p2 * next;
        const Three reach =
            halfA[i1] * size[i2] + halfA[i2] * size[i1] + halfB1 * last.abs() + halfB2 * next.abs();
        const Three length = next * next + last * last;
        const Three gap = (apart.abs() - reach).larger({0.0, 0.0, 0.0});
        const Three square = (gap * gap / length).where(length, kParallel);
        most = std::max(most, square.largest());
        squares[static_cast<std::size_t>(i)] = {square.low[0], square.low[1], square.high[0]};
    }
    if (best.gap <= 0.0 ? most > 0.0 : most > best.gap * best.gap)
    {
        for (int k = 0; k < 9; ++k)
        {
            const int i = k / 3;
            const int j = k % 3;
            const double square = squares[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
            if (square == most)
            {
                best = {.gap = std::sqrt(most), .edgeA = i, .edgeB = j};
                break;
            }
        }
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
    // Along an axis that is normal to the direction all points are as far: the one nearest to a
    // place is taken.
    constexpr double kFlat = 1e-15;
    const auto farthest =
        [](const Vector3d& half, const Vector3d& direction, const Vector3d& place) -> Vector3d
    {
        const auto coordinate = [&](Eigen::Index k)
        {
            return std::abs(direction[k]) <= kFlat ? std::clamp(place[k], -half[k], half[k])
                                                   : std::copysign(half[k], direction[k]);
        };
        return {coordinate(0), coordinate(1), coordinate(2)};
    };
    const auto isInside = [](const Vector3d& x, const Vector3d& half, int across)
    {
        const int k = (across + 1) % 3;
        const int m = (across + 2) % 3;
        return (static_cast<int>(std::abs(x[k]) <= half[k]) &
                static_cast<int>(std::abs(x[m]) <= half[m])) != 0;
    };
    Vector3d inA = farthest(halfA, pose.R.transpose() * n, pose.R.transpose() * -pose.p);
    Vector3d inB = farthest(halfB, -n, pose.p);
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
