#include "benchmarks/reference/oracles/brute_force_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace bullet_ccd::reference
{
namespace
{
using LongReal = long double;
template <typename Real>
using Vector = Eigen::Matrix<Real, 3, 1>;
template <typename Real>
using CornersOf = std::array<Vector<Real>, 3>;

/// The smallest distance so far, between points that lie on the two triangles.
template <typename Real>
struct Best
{
    Real squared = std::numeric_limits<Real>::infinity();
    Vector<Real> onA = Vector<Real>::Zero();
    Vector<Real> onB = Vector<Real>::Zero();

    void offer(const Vector<Real>& a, const Vector<Real>& b)
    {
        const Real candidate = (a - b).squaredNorm();
        if (candidate < squared)
        {
            squared = candidate;
            onA = a;
            onB = b;
        }
    }
};

template <typename Real>
Vector<Real> closestOnSegment(const Vector<Real>& point,
                              const Vector<Real>& start,
                              const Vector<Real>& end)
{
    const Vector<Real> along = end - start;
    const Real lengthSquared = along.squaredNorm();
    if (lengthSquared == 0)
    {
        return start;
    }
    const Real s = std::clamp<Real>(along.dot(point - start) / lengthSquared, 0, 1);
    return start + s * along;
}

template <typename Real>
void offerEdges(const Vector<Real>& p0,
                const Vector<Real>& p1,
                const Vector<Real>& q0,
                const Vector<Real>& q1,
                Best<Real>& best)
{
    best.offer(p0, closestOnSegment(p0, q0, q1));
    best.offer(p1, closestOnSegment(p1, q0, q1));
    best.offer(closestOnSegment(q0, p0, p1), q0);
    best.offer(closestOnSegment(q1, p0, p1), q1);

    const Vector<Real> u = p1 - p0;
    const Vector<Real> v = q1 - q0;
    const Vector<Real> w = q0 - p0;
    const Vector<Real> normal = u.cross(v);
    const Real det = normal.squaredNorm();
    if (det == 0)
    {
        return;
    }
    // p0 + s u and q0 + t v differ by a multiple of the common normal.
    const Real s = w.cross(v).dot(normal) / det;
    const Real t = w.cross(u).dot(normal) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1)
    {
        best.offer(p0 + s * u, q0 + t * v);
    }
}

/// The foot of the perpendicular from `point`, if it lies in the triangle.
template <typename Real>
bool projectInto(const Vector<Real>& point, const CornersOf<Real>& triangle, Vector<Real>& foot)
{
    const Vector<Real> normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    const Real det = normal.squaredNorm();
    if (det == 0)
    {
        return false;
    }
    std::array<Real, 3> weight{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector<Real>& from = triangle[(k + 1) % 3];
        const Vector<Real>& to = triangle[(k + 2) % 3];
        weight[k] = (to - from).cross(point - from).dot(normal) / det;
        if (weight[k] < 0)
        {
            return false;
        }
    }
    foot = weight[0] * triangle[0] + weight[1] * triangle[1] + weight[2] * triangle[2];
    return true;
}

LongReal toTriangle(const Vector<LongReal>& point, const WideCorners& triangle)
{
    Vector<LongReal> foot;
    if (projectInto(point, triangle, foot))
    {
        return (foot - point).norm();
    }
    LongReal distance = std::numeric_limits<LongReal>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector<LongReal> near = closestOnSegment(point, triangle[k], triangle[(k + 1) % 3]);
        distance = std::min(distance, (near - point).norm());
    }
    return distance;
}

/// True if the segment properly meets the triangle's plane, inside the triangle.
bool crosses(const Vector<LongReal>& p,
             const Vector<LongReal>& q,
             const WideCorners& triangle,
             Vector<LongReal>& point)
{
    const Vector<LongReal> normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    const LongReal sideP = normal.dot(p - triangle[0]);
    const LongReal sideQ = normal.dot(q - triangle[0]);
    if ((sideP > 0 && sideQ > 0) || (sideP < 0 && sideQ < 0) || (sideP == 0 && sideQ == 0))
    {
        return false;
    }
    const Vector<LongReal> along = q - p;
    std::array<LongReal, 3> volume{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        volume[k] = along.dot((triangle[(k + 1) % 3] - p).cross(triangle[(k + 2) % 3] - p));
    }
    const auto [low, high] = std::minmax_element(volume.begin(), volume.end());
    const LongReal sum = volume[0] + volume[1] + volume[2];
    if ((*low < 0 && *high > 0) || sum == 0)
    {
        return false;
    }
    // In the plane of a sliver, volumes and sides are rounding and say nothing: the point of the
    // segment must lie on the triangle, as well as a sliver allows to compute it.
    point = p + sideP / (sideP - sideQ) * along;
    const LongReal size = along.cwiseAbs().sum() + (p - triangle[0]).cwiseAbs().sum();
    return toTriangle(point, triangle) <= 1e-12L * size;
}

WideCorners widen(const Corners& corners)
{
    return {corners[0].cast<LongReal>(), corners[1].cast<LongReal>(), corners[2].cast<LongReal>()};
}

WideCorners relativeTo(const Vector<LongReal>& origin, const WideCorners& corners)
{
    return {corners[0] - origin, corners[1] - origin, corners[2] - origin};
}

bool findCrossing(const WideCorners& a, const WideCorners& b, Vector<LongReal>& point)
{
    for (std::size_t k = 0; k < 3; ++k)
    {
        if (crosses(a[k], a[(k + 1) % 3], b, point) || crosses(b[k], b[(k + 1) % 3], a, point))
        {
            return true;
        }
    }
    return false;
}

/// Of two triangles that do not cross.
template <typename Real>
Best<Real> closestPoints(const CornersOf<Real>& a, const CornersOf<Real>& b)
{
    Best<Real> best;
    for (std::size_t i = 0; i < 3; ++i)
    {
        for (std::size_t j = 0; j < 3; ++j)
        {
            offerEdges(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3], best);
        }
        Vector<Real> foot;
        if (projectInto(a[i], b, foot))
        {
            best.offer(a[i], foot);
        }
        if (projectInto(b[i], a, foot))
        {
            best.offer(foot, b[i]);
        }
    }
    return best;
}

/// A triangle and a ball that contains it.
struct Bounded
{
    Corners corners;
    Eigen::Vector3d center;
    double radius = 0.0;
};

std::vector<Bounded> boundedTriangles(const TriangleMesh& mesh, const Eigen::Isometry3d& X)
{
    std::vector<Bounded> result(mesh.triangles.size());
    for (std::size_t i = 0; i < result.size(); ++i)
    {
        Bounded& item = result[i];
        item.corners = cornersOf(mesh, i);
        for (Eigen::Vector3d& corner : item.corners)
        {
            corner = X * corner;
        }
        item.center = (item.corners[0] + item.corners[1] + item.corners[2]) / 3.0;
        for (const Eigen::Vector3d& corner : item.corners)
        {
            item.radius = std::max(item.radius, (corner - item.center).norm());
        }
        // Rounding of the centre and of the distances to it.
        item.radius += 1e-14 * (item.radius + item.center.norm());
    }
    return result;
}
}  // namespace

OracleDistance bruteForceTriangleDistance(const Corners& a, const Corners& b)
{
    return bruteForceTriangleDistance(widen(a), widen(b));
}

OracleDistance bruteForceTriangleDistance(const WideCorners& a, const WideCorners& b)
{
    const Vector<LongReal> origin = a[0];
    const WideCorners wideA = relativeTo(origin, a);
    const WideCorners wideB = relativeTo(origin, b);
    OracleDistance result;
    Vector<LongReal> point;
    if (findCrossing(wideA, wideB, point))
    {
        result.pointA = result.pointB = (point + origin).cast<double>();
        return result;
    }
    const Best<LongReal> best = closestPoints<LongReal>(wideA, wideB);
    result.distance = static_cast<double>(std::sqrt(best.squared));
    result.pointA = (best.onA + origin).cast<double>();
    result.pointB = (best.onB + origin).cast<double>();
    return result;
}

Eigen::Vector3d directionBetween(const Corners& a, const Corners& b)
{
    const Best<double> best = closestPoints<double>(a, b);
    return (best.onB - best.onA).stableNormalized();
}

double gapAlong(const Eigen::Vector3d& n, const Corners& a, const Corners& b)
{
    const auto [lowA, highA] = std::minmax({n.dot(a[0]), n.dot(a[1]), n.dot(a[2])});
    const auto [lowB, highB] = std::minmax({n.dot(b[0]), n.dot(b[1]), n.dot(b[2])});
    return lowB - highA - 1e-14 * (std::max(-lowA, highA) + std::max(-lowB, highB));
}

OracleDistance bruteForceMeshDistance(const TriangleMesh& meshA,
                                      const TriangleMesh& meshB,
                                      const Eigen::Isometry3d& X_BA)
{
    const std::vector<Bounded> listA = boundedTriangles(meshA, X_BA);
    const std::vector<Bounded> listB = boundedTriangles(meshB, Eigen::Isometry3d::Identity());
    const auto gapOfBalls = [&](std::size_t i, std::size_t j)
    { return (listA[i].center - listB[j].center).norm() - listA[i].radius - listB[j].radius; };

    // Start with the pair whose balls are closest: it makes most others skippable.
    std::size_t firstA = 0;
    std::size_t firstB = 0;
    for (std::size_t i = 0; i < listA.size(); ++i)
    {
        for (std::size_t j = 0; j < listB.size(); ++j)
        {
            if (gapOfBalls(i, j) < gapOfBalls(firstA, firstB))
            {
                firstA = i;
                firstB = j;
            }
        }
    }
    OracleDistance best = bruteForceTriangleDistance(listA[firstA].corners, listB[firstB].corners);
    best.triangleA = static_cast<std::int32_t>(firstA);
    best.triangleB = static_cast<std::int32_t>(firstB);
    for (std::size_t i = 0; i < listA.size() && best.distance > 0.0; ++i)
    {
        for (std::size_t j = 0; j < listB.size() && best.distance > 0.0; ++j)
        {
            const Corners& a = listA[i].corners;
            const Corners& b = listB[j].corners;
            if (gapOfBalls(i, j) > best.distance ||
                gapAlong(directionBetween(a, b), a, b) > best.distance)
            {
                continue;
            }
            OracleDistance pair = bruteForceTriangleDistance(a, b);
            if (pair.distance < best.distance)
            {
                best = pair;
                best.triangleA = static_cast<std::int32_t>(i);
                best.triangleB = static_cast<std::int32_t>(j);
            }
        }
    }
    return best;
}

double distanceToTriangle(const Eigen::Vector3d& point, const Corners& triangle)
{
    return bruteForceTriangleDistance({point, point, point}, triangle).distance;
}

double distanceToMesh(const Eigen::Vector3d& point, const TriangleMesh& mesh)
{
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        distance = std::min(distance, distanceToTriangle(point, cornersOf(mesh, i)));
    }
    return distance;
}

Corners cornersOf(const TriangleMesh& mesh, std::size_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    const auto vertex = [&](std::size_t k)
    { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    return {vertex(0), vertex(1), vertex(2)};
}
}  // namespace bullet_ccd::reference
