#include "bullet_ccd/toi/pair_step.h"

#include "bullet_ccd/distance/ssv_pair.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Longest time in which a gap g > 0 cannot close, if it closes at speed a now and at an
/// acceleration of at most b: the root of a s + b s^2 / 2 = g.
double closingTime(double g, double a, double b)
{
    const double root = std::sqrt(a * a + 2.0 * b * g);
    if (a >= 0.0)
    {
        return a + root > 0.0 ? 2.0 * g / (a + root) : kInfinity;
    }
    // Moving apart: without cancellation for b > 0; never closes for b = 0.
    return b > 0.0 ? (root - a) / b : kInfinity;
}

/// One corner: where it is, and its velocity and acceleration bound.
struct MovingCorner
{
    Vector3d point;
    Vector3d velocity;
    double acceleration;
};

/// Step along direction n (unit, from A to B): every pair of corners has its own gap and speed.
/// Also returns the smallest gap, the separation of the two triangles along n.
Step cornerStep(const std::array<MovingCorner, 3>& a,
                const std::array<MovingCorner, 3>& b,
                const Vector3d& n,
                double margin)
{
    Step step{.time = kInfinity, .gap = kInfinity};
    for (const MovingCorner& cornerA : a)
    {
        for (const MovingCorner& cornerB : b)
        {
            const double gap = n.dot(cornerB.point - cornerA.point);
            step.gap = std::min(step.gap, gap);
            if (gap <= margin)
            {
                step.time = 0.0;
                continue;
            }
            const double speed = n.dot(cornerA.velocity - cornerB.velocity);
            step.time = std::min(
                step.time,
                closingTime(gap - margin, speed, cornerA.acceleration + cornerB.acceleration));
        }
    }
    return step;
}

std::array<MovingCorner, 3> movingCorners(const TriangleCorners& corners,
                                          const Vector3d& offset,
                                          const AccelerationBound& bound,
                                          const Matrix3d& R,
                                          const Vector3d& p,
                                          const Vector3d& v,
                                          const Vector3d& w)
{
    std::array<MovingCorner, 3> moving;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector3d arm = R * corners[k];
        moving[k].point = arm + p;
        moving[k].velocity = v + w.cross(arm);
        moving[k].acceleration = bound.constant + bound.perRadius * (corners[k] + offset).norm();
    }
    return moving;
}

/// Best step over all directions that can separate two triangles; the fallback where the closest
/// points are too close, or too badly conditioned, to give a direction.
Step separatingStep(const std::array<MovingCorner, 3>& a,
                    const std::array<MovingCorner, 3>& b,
                    double margin)
{
    Step best;
    const auto consider = [&](const Vector3d& direction)
    {
        const double length = direction.norm();
        if (!(length > 0.0))
        {
            return;
        }
        for (const double sign : {1.0, -1.0})
        {
            const Step step = cornerStep(a, b, (sign / length) * direction, margin);
            if (step.gap > best.gap)
            {
                best = step;
            }
        }
    };
    std::array<Vector3d, 3> edgesA;
    std::array<Vector3d, 3> edgesB;
    for (std::size_t k = 0; k < 3; ++k)
    {
        edgesA[k] = a[(k + 1) % 3].point - a[k].point;
        edgesB[k] = b[(k + 1) % 3].point - b[k].point;
    }
    consider(edgesA[0].cross(edgesA[1]));
    consider(edgesB[0].cross(edgesB[1]));
    for (const Vector3d& edgeA : edgesA)
    {
        for (const Vector3d& edgeB : edgesB)
        {
            consider(edgeA.cross(edgeB));
        }
    }
    return best;
}
}  // namespace

/// Certified step of two volumes: the best over all separating axes. Speeds: that of the centres,
/// plus that of the core about its centre; the ball swept around the core does not feel rotation.
Step nodeStep(const PairConstants& c,
              const PairState& s,
              const SsvNode& nodeA,
              const SsvNode& nodeB)
{
    const PlacedSsv b = place(nodeB);
    PlacedSsv a = place(nodeA);
    const double reachA = (a.center + c.offsetA).norm() + a.coreRadius;
    const double reachB = (b.center + c.offsetB).norm() + b.coreRadius;
    const Vector3d armA = s.R * a.center;
    a.center = armA + s.p;
    a.axes = s.R * a.axes;

    const double acceleration = c.accelerationA.constant + c.accelerationB.constant +
                                c.accelerationA.perRadius * reachA +
                                c.accelerationB.perRadius * reachB;
    const double turning = s.spinA * a.coreRadius + s.spinB * b.coreRadius;
    const Vector3d closing = s.vA + s.wA.cross(armA) - s.vB - s.wB.cross(b.center);
    const Vector3d closingA = a.axes.transpose() * closing;
    const Vector3d closingB = b.axes.transpose() * closing;
    const double margin = 0.5 * c.threshold + s.rounding;

    Step step;
    forEachSeparatingAxis(a,
                          b,
                          [&](double gap, const auto& along)
                          {
                              step.gap = std::max(step.gap, gap);
                              if (gap > margin)
                              {
                                  const double speed = along(closingA, closingB) + turning;
                                  step.time = std::max(
                                      step.time, closingTime(gap - margin, speed, acceleration));
                              }
                              return s.time + step.time > 1.0;
                          });
    return step;
}

TriangleStep triangleStep(const PairConstants& c,
                          const PairState& s,
                          std::int32_t triangleA,
                          std::int32_t triangleB)
{
    const auto a = movingCorners(
        c.treeA->corners(triangleA), c.offsetA, c.accelerationA, s.R, s.p, s.vA, s.wA);
    const auto b = movingCorners(c.treeB->corners(triangleB),
                                 c.offsetB,
                                 c.accelerationB,
                                 Matrix3d::Identity(),
                                 Vector3d::Zero(),
                                 s.vB,
                                 s.wB);
    TriangleStep result;
    result.distance = triangleDistance({a[0].point, a[1].point, a[2].point},
                                       {b[0].point, b[1].point, b[2].point});
    const double margin = 0.5 * c.threshold + s.rounding;
    const double d = result.distance.distance;
    if (d <= 0.0)
    {
        return result;
    }
    Step step = cornerStep(a, b, (result.distance.pointB - result.distance.pointA) / d, margin);
    if (step.gap < 0.99 * d)
    {
        const Step other = separatingStep(a, b, margin);
        step = other.gap > step.gap ? other : step;
    }
    result.time = step.time;
    return result;
}
}  // namespace bullet_ccd
