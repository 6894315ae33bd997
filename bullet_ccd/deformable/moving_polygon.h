/// The difference of two features: a convex polygon whose corners move on straight lines, and when
/// it is certainly apart from the origin. Internal to the room.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace bullet_ccd
{
/// A triangle (N = 3), or a parallelogram in cyclic order (N = 4).
template <std::size_t N>
using Polygon = std::array<Eigen::Vector3d, N>;

/// Second feature minus first. A vertex p and a face a, b, c: a - p, b - p, c - p.
inline void subtract(const FourPoints& x, Polygon<3>& q)
{
    q = {x[1] - x[0], x[2] - x[0], x[3] - x[0]};
}
/// Two edges: the corners are where both are at an end.
inline void subtract(const FourPoints& x, Polygon<4>& q)
{
    q = {x[2] - x[0], x[3] - x[0], x[3] - x[1], x[2] - x[1]};
}

/// The share of each vertex in a point of the polygon that is given by the weights of its corners.
inline Eigen::Vector4d vertexWeights(const std::array<double, 3>& c)
{
    return {-(c[0] + c[1] + c[2]), c[0], c[1], c[2]};
}
inline Eigen::Vector4d vertexWeights(const std::array<double, 4>& c)
{
    return {-(c[0] + c[1]), -(c[2] + c[3]), c[0] + c[3], c[1] + c[2]};
}

/// The point of a polygon that is nearest to the origin. Only a proposal: nothing is concluded from
/// it that certify() or the offsets of all corners do not confirm.
struct NearestPoint
{
    double distance = 0.0;
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, from the origin to the point
    bool isInside = false;
    /// Inside: the point is q0 + u (q1 - q0) + v (q[N-1] - q0). Else it is on the edge from corner
    /// `edge` on, u of the way.
    std::size_t edge = 0;
    double u = 0.0;
    double v = 0.0;

    template <std::size_t N>
    [[nodiscard]] std::array<double, N> cornerWeights() const
    {
        std::array<double, N> c{};
        if (isInside)
        {
            c[0] = 1.0 - u - v;
            c[1] = u;
            c[N - 1] = v;
        }
        else
        {
            c[edge] = 1.0 - u;
            c[(edge + 1) % N] = u;
        }
        return c;
    }

    /// Speed of the point along the direction, if the corners move with `w`.
    template <std::size_t N>
    [[nodiscard]] double rate(const Polygon<N>& w) const
    {
        if (isInside)
        {
            return direction.dot(w[0] + u * (w[1] - w[0]) + v * (w[N - 1] - w[0]));
        }
        const std::size_t next = edge + 1 == N ? 0 : edge + 1;
        return direction.dot(w[edge] + u * (w[next] - w[edge]));
    }
};

template <std::size_t N>
inline NearestPoint nearestPoint(const Polygon<N>& q)
{
    NearestPoint nearest;
    double bestSquared = std::numeric_limits<double>::infinity();
    Eigen::Vector3d point = q[0];
    for (std::size_t k = 0; k < N; ++k)
    {
        const Eigen::Vector3d& a = q[k];
        const Eigen::Vector3d e = q[k + 1 == N ? 0 : k + 1] - a;
        const double along = -a.dot(e);
        const double ee = e.squaredNorm();
        const double u = along <= 0.0 ? 0.0 : along >= ee ? 1.0 : along / ee;
        const Eigen::Vector3d c = a + u * e;
        const double squared = c.squaredNorm();
        if (squared < bestSquared)
        {
            bestSquared = squared;
            nearest.edge = k;
            nearest.u = u;
            point = c;
        }
    }
    const Eigen::Vector3d e = q[1] - q[0];
    const Eigen::Vector3d f = q[N - 1] - q[0];
    const Eigen::Vector3d m = e.cross(f);
    const double mm = m.squaredNorm();
    bool isInside = mm > 0.0;
    for (std::size_t k = 0; k < N; ++k)
    {
        isInside = isInside && q[k].cross(q[k + 1 == N ? 0 : k + 1]).dot(m) > 0.0;
    }
    const double height = m.dot(q[0]);
    if (isInside && height * height / mm < bestSquared)
    {
        const double length = std::sqrt(mm);
        const double ee = e.squaredNorm();
        const double ef = e.dot(f);
        const double ff = f.squaredNorm();
        const double ae = -q[0].dot(e);
        const double af = -q[0].dot(f);
        const double determinant = ee * ff - ef * ef;
        nearest.isInside = true;
        nearest.u = determinant > 0.0 ? (ae * ff - af * ef) / determinant : 0.0;
        nearest.v = determinant > 0.0 ? (af * ee - ae * ef) / determinant : 0.0;
        nearest.distance = std::abs(height) / length;
        nearest.direction = (height < 0.0 ? -1.0 : 1.0) / length * m;
        return nearest;
    }
    nearest.distance = std::sqrt(bestSquared);
    if (nearest.distance > 0.0)
    {
        nearest.direction = point / nearest.distance;
    }
    // The direction to a point this close has lost half of its digits. It is turned so that both
    // ends of the edge are equally far, or, above an edge, all corners.
    constexpr double kCloseSquared = 1e-14;
    if (bestSquared < kCloseSquared * (e.squaredNorm() + f.squaredNorm()))
    {
        const Eigen::Vector3d along =
            q[nearest.edge + 1 == N ? 0 : nearest.edge + 1] - q[nearest.edge];
        if (height * height > 0.98 * bestSquared * mm && mm > 0.0)
        {
            nearest.direction = (height < 0.0 ? -1.0 : 1.0) / std::sqrt(mm) * m;
        }
        else if (nearest.u > 0.0 && nearest.u < 1.0)
        {
            nearest.direction -= nearest.direction.dot(along) / along.squaredNorm() * along;
        }
    }
    return nearest;
}

/// True only if the polygon, at `a` when an interval begins and at `b` when it ends, is farther
/// than `margin` from the origin in all of it.
///
/// One of three certificates: along n0 or along n1 every corner exceeds the margin at both ends; or
/// along n(s) = (1 - s) n0 + s n1 it does at all times. The product of n(s) with a corner is a
/// quadratic in s with the Bernstein coefficients b0, b1, b2, which is positive on [0, 1] if b0 >
/// 0, b2 > 0 and b1 > -sqrt(b0 b2). |n(s)| <= 1 makes the product a lower bound of the distance.
template <std::size_t N>
inline bool certify(const Polygon<N>& a,
                    const Polygon<N>& b,
                    const Eigen::Vector3d& n0,
                    const Eigen::Vector3d& n1,
                    double margin)
{
    bool fixed0 = true;
    bool fixed1 = true;
    bool turning = true;
    for (std::size_t k = 0; k < N; ++k)
    {
        const double a0 = n0.dot(a[k]) - margin;
        const double b0 = n0.dot(b[k]) - margin;
        const double a1 = n1.dot(a[k]) - margin;
        const double b1 = n1.dot(b[k]) - margin;
        fixed0 = fixed0 && a0 > 0.0 && b0 > 0.0;  // false for what is not a number, too
        fixed1 = fixed1 && a1 > 0.0 && b1 > 0.0;
        const double middle = 0.5 * (b0 + a1);
        turning = turning && a0 > 0.0 && b1 > 0.0 &&
                  (middle > 0.0 || middle * middle < 0.999999 * a0 * b1);
    }
    return fixed0 || fixed1 || turning;
}

/// How long the direction n alone keeps the polygon farther than `margin` from the origin, at most
/// `most`; 0 if it does not do so now. Exact, because all offsets are linear in time.
template <std::size_t N>
inline double supportStep(
    const Polygon<N>& q, const Polygon<N>& w, const Eigen::Vector3d& n, double margin, double most)
{
    double step = most;
    for (std::size_t k = 0; k < N; ++k)
    {
        const double offset = n.dot(q[k]) - margin;
        const double rate = n.dot(w[k]);
        if (!(offset > 0.0))  // not a number, too
        {
            return 0.0;
        }
        if (rate < 0.0)
        {
            step = std::min(step, offset / -rate * (1.0 - 1e-12));
        }
    }
    return step;
}
}  // namespace bullet_ccd
