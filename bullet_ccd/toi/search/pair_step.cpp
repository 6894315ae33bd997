#include "bullet_ccd/toi/search/pair_step.h"

#include "bullet_ccd/distance/extent.h"
#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/math/check.h"

#include <array>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Map<const Vector3d> vector(const double (&v)[3])
{
    return Map<const Vector3d>(v);
}

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

/// One side of a pair of volumes: how its core moves about its center.
struct CoreMotion
{
    Vector3d axis;  // unit, or zero
    double turn;    // speed, times |axis x n|
    double bend;    // acceleration, times |axis x n|

    CoreMotion(const Vector3d& w, double spin, const Vector3d& orbit, double axisPart, double core)
        : axis(spin > 0.0 ? Vector3d(w / spin) : Vector3d(Vector3d::Zero())),
          turn(spin * core),
          bend(axisPart * spin * (orbit.norm() + spin * core))
    {
    }
};

double across(double along)
{
    return std::sqrt(std::max(0.0, 1.0 - along * along) + 1e-14);
}

/// Best gap and best step over all directions that can separate two triangles; where the closest
/// points are too close, or too badly conditioned, to give a direction. `across` is that of the
/// closest points: made perpendicular to an edge it is the direction between the edge and a corner.
TriangleApproach bestApproach(const RelativeMotion& motion,
                              const TriangleCorners& cornersA,
                              const TriangleCorners& cornersB,
                              const Vector3d& across,
                              double margin)
{
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(motion.R);
    std::array<Vector3d, 3> edgesA;
    std::array<Vector3d, 3> edgesB;
    for (std::size_t k = 0; k < 3; ++k)
    {
        edgesA[k] = R * (cornersA[(k + 1) % 3] - cornersA[k]);
        edgesB[k] = cornersB[(k + 1) % 3] - cornersB[k];
    }
    TriangleApproach best{};
    best.gap = -kInfinity;
    const auto consider = [&](const Vector3d& direction)
    {
        const double length = direction.norm();
        if (!(length > 0.0))
        {
            return;
        }
        for (const double sign : {1.0, -1.0})
        {
            const Vector3d n = (sign / length) * direction;
            TriangleApproach approach{};
            approachAlong(
                motion, cornersA[0].data(), cornersB[0].data(), n.data(), margin, approach);
            best.gap = std::max(best.gap, approach.gap);
            best.time = std::max(best.time, approach.time);
        }
    };
    consider(edgesA[0].cross(edgesA[1]));
    consider(edgesB[0].cross(edgesB[1]));
    for (const Vector3d& edgeA : edgesA)
    {
        for (const Vector3d& edgeB : edgesB)
        {
            consider(edgeA.cross(edgeB));
        }
    }
    for (const auto* edges : {&edgesA, &edgesB})
    {
        for (const Vector3d& edge : *edges)
        {
            const double square = edge.squaredNorm();
            consider(square > 0.0 ? Vector3d(across - edge.dot(across) / square * edge) : across);
        }
    }
    return best;
}

/// Time in which no two corners can come nearer by `room`, whatever the direction: a step for
/// triangles as near as parallel edges, whose closest points give no direction that separates.
double anyDirectionTime(const RelativeMotion& m,
                        const TriangleCorners& cornersA,
                        const TriangleCorners& cornersB,
                        double room)
{
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    double speed = 0.0;
    double bend = 0.0;
    for (const Vector3d& cornerA : cornersA)
    {
        const Vector3d orbitA = vector(m.wA).cross(R * (cornerA + vector(m.armA)));
        const double bendA = m.constant + m.perRadiusA * (cornerA + vector(m.radiusArmA)).norm() +
                             m.axisA * m.spinA * orbitA.norm();
        for (const Vector3d& cornerB : cornersB)
        {
            const Vector3d armB = cornerB + vector(m.armB);
            const Vector3d orbitB = vector(m.wB).cross(armB);
            speed = std::max(speed, (vector(m.velocity) + orbitA - orbitB).norm());
            bend = std::max(bend,
                            bendA + m.perRadiusB * armB.norm() + m.axisB * m.spinB * orbitB.norm());
        }
    }
    return closingTime(room, speed, bend);
}

/// Exact distance of the triangles in B's tree.
TriangleDistance exactDistance(const RelativeMotion& m,
                               TriangleCorners cornersA,
                               const TriangleCorners& cornersB)
{
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    for (Vector3d& corner : cornersA)
    {
        corner = R * (corner + vector(m.armA)) + vector(m.p);
    }
    return triangleDistance(cornersA, cornersB);
}

/// How far the whole mesh reaches against a direction, in the frame of its tree.
double lowestVertex(const SsvTree& tree, const Vector3d& n)
{
    double lowest = kInfinity;
    for (const Vector3d& vertex : tree.mesh().vertices)
    {
        lowest = std::min(lowest, n.dot(vertex - tree.origin()));
    }
    return lowest;
}
}  // namespace

Step nodeStep(const RelativeMotion& m, double margin, const SsvNode& nodeA, const SsvNode& nodeB)
{
    const PlacedSsv b = place(nodeB);
    PlacedSsv a = place(nodeA);
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    const Vector3d fromReference = a.center + vector(m.radiusArmA);
    const Vector3d arm = R * (a.center + vector(m.armA));
    const Vector3d armB = b.center + vector(m.armB);
    a.center = arm + vector(m.p);
    a.axes = R * a.axes;

    const Vector3d orbitA = vector(m.wA).cross(arm);
    const Vector3d orbitB = vector(m.wB).cross(armB);
    const CoreMotion coreA(vector(m.wA), m.spinA, orbitA, m.axisA, a.coreRadius);
    const CoreMotion coreB(vector(m.wB), m.spinB, orbitB, m.axisB, b.coreRadius);
    const double constant = m.constant + m.perRadiusA * (fromReference.norm() + a.coreRadius) +
                            m.perRadiusB * (armB.norm() + b.coreRadius);
    const Vector3d closing = vector(m.velocity) + orbitA - orbitB;
    const std::array<Vector3d, 3> inA{a.axes.transpose() * closing,
                                      a.axes.transpose() * coreA.axis,
                                      a.axes.transpose() * coreB.axis};
    const std::array<Vector3d, 3> inB{b.axes.transpose() * closing,
                                      b.axes.transpose() * coreA.axis,
                                      b.axes.transpose() * coreB.axis};
    Step step;
    forEachSeparatingAxis(
        a,
        b,
        [&](double gap, const auto& along)
        {
            step.gap = std::max(step.gap, gap);
            if (gap > margin)
            {
                const double acrossA = across(along(inA[1], inB[1]));
                const double acrossB = across(along(inA[2], inB[2]));
                const double speed =
                    along(inA[0], inB[0]) + coreA.turn * acrossA + coreB.turn * acrossB;
                const double bend = constant + coreA.bend * acrossA + coreB.bend * acrossB;
                step.time = std::max(step.time, closingTime(gap - margin, speed, bend));
            }
            return false;
        });
    return step;
}

Step flatStep(const SsvTree& treeA,
              const SsvTree& treeB,
              const PairState& state,
              double margin,
              std::int32_t indexA,
              std::int32_t indexB,
              bool byVertices)
{
    const RelativeMotion& m = state.motion;
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    const Vector3d place = R * vector(m.armA) + vector(m.p);
    const SsvNode& nodeA = treeA.nodes()[static_cast<std::size_t>(indexA)];
    const SsvNode& nodeB = treeB.nodes()[static_cast<std::size_t>(indexB)];
    const Vector3d centerA = Map<const Eigen::Vector3f>(nodeA.center).cast<double>();
    const Vector3d centerB = Map<const Eigen::Vector3f>(nodeB.center).cast<double>();
    const Vector3d across = centerB - (R * centerA + place);
    Step best;
    const auto consider = [&](const Vector3d& normal)
    {
        const Vector3d n = normal.dot(across) < 0.0 ? Vector3d(-normal) : normal;
        const Vector3d inA = R.transpose() * n;
        double gap = extentAlong(treeB, indexB, n).low - n.dot(place) -
                     extentAlong(treeA, indexA, inA).high - state.rounding;
        constexpr double kBlur = 0.5;  // of volumes, for the size of the smaller
        if (byVertices && gap > -kBlur * static_cast<double>(std::min(nodeA.size(), nodeB.size())))
        {
            gap =
                lowestVertex(treeB, n) - n.dot(place) + lowestVertex(treeA, -inA) - state.rounding;
        }
        if (gap <= best.gap)
        {
            return;
        }
        best.gap = gap;
        if (gap <= margin)
        {
            return;
        }
        const auto sizeA = static_cast<double>(nodeA.size());
        const auto sizeB = static_cast<double>(nodeB.size());
        const Vector3d armB = centerB + vector(m.armB);
        const Vector3d orbitA = vector(m.wA).cross(R * (centerA + vector(m.armA)));
        const Vector3d orbitB = vector(m.wB).cross(armB);
        const double turnA = vector(m.wA).cross(n).norm();
        const double turnB = vector(m.wB).cross(n).norm();
        const double speed =
            n.dot(vector(m.velocity) + orbitA - orbitB) + turnA * sizeA + turnB * sizeB;
        const bool hasPlane = !vector(m.plane).isZero(0.0);
        const double part = hasPlane ? vector(m.plane).cross(n).norm() + 1e-15 : 1.0;
        const double bend =
            part * (m.constant + m.perRadiusA * ((centerA + vector(m.radiusArmA)).norm() + sizeA) +
                    m.perRadiusB * (armB.norm() + sizeB)) +
            m.acrossPlane + m.axisA * turnA * (orbitA.norm() + m.spinA * sizeA) +
            m.axisB * turnB * (orbitB.norm() + m.spinB * sizeB);
        best.time = std::max(best.time, closingTime(gap - margin, speed, bend));
    };
    for (const Vector3d& normal : treeA.faceSlabs().normals)
    {
        consider(R * normal);
    }
    for (const Vector3d& normal : treeB.faceSlabs().normals)
    {
        consider(normal);
    }
    return best;
}

double slidingStep(const SsvTree& treeA,
                   const SsvTree& treeB,
                   const PairState& state,
                   double margin,
                   std::int32_t slotA,
                   std::int32_t slotB,
                   const Vector3d& across)
{
    const TriangleCorners cornersA = treeA.corners(slotA);
    const TriangleCorners cornersB = treeB.corners(slotB);
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(state.motion.R);
    // What is lost of the direction where points are very near counts along an edge of B most.
    Vector3d beside = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector3d edge = cornersB[(k + 1) % 3] - cornersB[k];
        const double square = edge.squaredNorm();
        const Vector3d part =
            square > 0.0 ? Vector3d(across - edge.dot(across) / square * edge) : across;
        beside = part.squaredNorm() > beside.squaredNorm() ? part : beside;
    }
    double longest = 0.0;
    for (const Vector3d& normal :
         {Vector3d(R * (cornersA[1] - cornersA[0]).cross(cornersA[2] - cornersA[0])),
          Vector3d((cornersB[1] - cornersB[0]).cross(cornersB[2] - cornersB[0])),
          beside})
    {
        const Vector3d n =
            (normal.dot(across) < 0.0 ? Vector3d(-normal) : normal).stableNormalized();
        if (n.isZero(0.0))
        {
            continue;
        }
        TriangleApproach approach{};
        approachAlong(state.motion,
                      cornersA[0].data(),
                      cornersB[0].data(),
                      n.data(),
                      margin + state.rounding,
                      approach);
        longest = std::max(longest, approach.time);
    }
    return longest;
}

TriangleStep triangleStep(const SsvTree& treeA,
                          const SsvTree& treeB,
                          const PairState& state,
                          double margin,
                          bool apart,
                          std::int32_t slotA,
                          std::int32_t slotB)
{
    const TriangleCorners cornersA = treeA.corners(slotA);
    const TriangleCorners cornersB = treeB.corners(slotB);
    const double keep = margin + state.rounding;
    TriangleApproach approach;
    approachTriangles(state.motion, cornersA[0].data(), cornersB[0].data(), keep, approach);
    const TriangleStep closest{.distance = {.distance = approach.distance,
                                            .pointA = vector(approach.pointA),
                                            .pointB = vector(approach.pointB)},
                               .time = approach.time};
    // The direction of the closest points separates by their distance, or something is wrong: a
    // lower bound may fall short of an upper one, and never exceeds it.
    // Above a clearance, what counts is the part of the distance that is beyond it.
    const double room = approach.distance - keep;
    const bool separates = approach.gap >= 0.99 * approach.distance &&
                           (room <= 0.0 || approach.gap - keep >= 0.25 * room);
    if (separates && approach.distance > state.rounding &&
        approach.gap <= approach.distance + state.rounding)
    {
        return closest;
    }
    TriangleStep result{.distance = exactDistance(state.motion, cornersA, cornersB)};
    if (result.distance.distance <= 0.0)
    {
        // Slivers may seem to cross where they are known to be apart.
        return apart && approach.distance > 0.0 ? closest : result;
    }
    // Both are distances of points of the triangles; of slivers either may be the shorter.
    if (approach.distance > 0.0 && approach.distance < result.distance.distance)
    {
        result.distance = closest.distance;
    }
    const Vector3d across = result.distance.pointB - result.distance.pointA;
    const TriangleApproach best = bestApproach(state.motion, cornersA, cornersB, across, keep);
    BULLET_CCD_ASSERT(best.gap <= result.distance.distance + state.rounding);
    result.time = std::max(best.time, approach.time);
    // A gap along a direction is certain. Of slivers a distance is not, so it decides only where no
    // direction says enough.
    const double exactRoom = result.distance.distance - keep;
    if (exactRoom > 0.0 && best.gap - keep < 0.25 * exactRoom)
    {
        result.time =
            std::max(result.time, anyDirectionTime(state.motion, cornersA, cornersB, exactRoom));
    }
    return result;
}
}  // namespace bullet_ccd
