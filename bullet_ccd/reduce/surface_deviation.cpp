#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/reduce/nearest_triangle.h"
#include "bullet_ccd/reduce/reduce_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <tbb/parallel_for.h>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Share of the largest distance by which the bounds may differ.
constexpr double kShare = 0.01;
constexpr int kMostPieces = 100'000;
constexpr int kPiecesBetweenLooks = 64;

void throwIfDue(const StopCondition& stop)
{
    if (stop.isDue())
    {
        throw QueryStopped("deviation: the search was stopped before its end");
    }
}

/// A convex polygon: a piece of a triangle.
using Polygon = std::vector<Vector3d>;

/// The parts of a convex polygon on both sides of a plane, {x : normal.(x - point) >= 0} first. A
/// polygon that does not reach to both sides, up to rounding, stays whole: in the plane itself the
/// signs of the heights are noise.
std::pair<Polygon, Polygon> cut(const Polygon& polygon,
                                const Vector3d& point,
                                const Vector3d& normal)
{
    constexpr double kRounding = 1e-14;
    std::vector<double> heights;
    double low = 0.0;
    double high = 0.0;
    for (const Vector3d& corner : polygon)
    {
        const double rounding = kRounding * normal.norm() * (corner.norm() + point.norm());
        const double height = normal.dot(corner - point);
        heights.push_back(std::abs(height) <= rounding ? 0.0 : height);
        low = std::min(low, heights.back());
        high = std::max(high, heights.back());
    }
    if (low >= 0.0)
    {
        return {polygon, {}};
    }
    if (high <= 0.0)
    {
        return {{}, polygon};
    }
    std::pair<Polygon, Polygon> parts;
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        const std::size_t j = (i + 1) % polygon.size();
        if (heights[i] >= 0.0)
        {
            parts.first.push_back(polygon[i]);
        }
        if (heights[i] <= 0.0)
        {
            parts.second.push_back(polygon[i]);
        }
        if (heights[i] * heights[j] < 0.0)
        {
            const Vector3d crossing =
                polygon[i] + heights[i] / (heights[i] - heights[j]) * (polygon[j] - polygon[i]);
            parts.first.push_back(crossing);
            parts.second.push_back(crossing);
        }
    }
    return parts;
}

/// A polygon without three corners has no area: its border belongs to its neighbours.
bool hasArea(const Polygon& polygon)
{
    return polygon.size() >= 3;
}

double areaOf(const Polygon& polygon)
{
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 2; i < polygon.size(); ++i)
    {
        sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
    }
    return 0.5 * sum.norm();
}

Vector3d middleOf(const Polygon& polygon)
{
    Vector3d sum = Vector3d::Zero();
    for (const Vector3d& corner : polygon)
    {
        sum += corner;
    }
    return sum / static_cast<double>(polygon.size());
}

/// The polygon halved across its longest edge or diagonal.
std::pair<Polygon, Polygon> halved(const Polygon& polygon)
{
    Vector3d from = polygon[0];
    Vector3d to = polygon[1];
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        for (std::size_t j = i + 1; j < polygon.size(); ++j)
        {
            if ((polygon[j] - polygon[i]).squaredNorm() > (to - from).squaredNorm())
            {
                from = polygon[i];
                to = polygon[j];
            }
        }
    }
    return cut(polygon, 0.5 * (from + to), to - from);
}

/// One triangle of the surface, cut into pieces until each has a triangle of the tree that is near
/// at all of its corners.
class TriangleDeviation
{
public:
    /// @param near bounds up to here need not be improved
    TriangleDeviation(const SsvTree& tree, double near, double limit, const StopCondition& stop)
        : m_tree(tree), m_near(near), m_limit(limit), m_stop(stop)
    {
    }

    Deviation run(const TriangleCorners& corners, std::int32_t& guess)
    {
        m_guess = guess;
        m_pieces.clear();
        m_pieces.push_back({corners[0], corners[1], corners[2]});
        for (int done = 0; !m_pieces.empty(); ++done)
        {
            if (done % kPiecesBetweenLooks == 0)
            {
                throwIfDue(m_stop);
            }
            const Polygon piece = std::move(m_pieces.back());
            m_pieces.pop_back();
            look(piece, done >= kMostPieces);
            guess = m_guess;
            if (m_result.lower > m_limit)
            {
                m_result.upper = kInfinity;
                return m_result;
            }
        }
        m_result.upper = std::max(m_result.upper, m_result.lower);
        return m_result;
    }

private:
    [[nodiscard]] bool isEnough(double distance) const
    {
        return distance <= std::max(m_near, (1.0 + kShare) * m_result.lower);
    }

    /// Distance of a point from the tree, which the result is told.
    Nearest measure(const Vector3d& point)
    {
        const Nearest nearest = nearestTriangle(m_tree, point, m_guess);
        m_guess = nearest.slot;
        if (nearest.distance > m_result.lower)
        {
            m_result.lower = nearest.distance;
            m_result.point = point;
        }
        return nearest;
    }

    void push(std::pair<Polygon, Polygon> parts)
    {
        for (Polygon* part : {&parts.first, &parts.second})
        {
            if (hasArea(*part))
            {
                m_pieces.push_back(std::move(*part));
            }
        }
    }

    void look(const Polygon& piece, bool giveUp)
    {
        const Nearest nearest = measure(middleOf(piece));
        double farthest = 0.0;
        Vector3d corner = piece.front();
        for (const Vector3d& point : piece)
        {
            const double d = pointToTriangle(point, m_tree.corners(nearest.slot)).distance;
            if (d > farthest)
            {
                farthest = d;
                corner = point;
            }
        }
        if (!isEnough(farthest) && !giveUp)
        {
            measure(corner);  // often nothing else is nearer there, either
        }
        if (isEnough(farthest) || giveUp)
        {
            m_result.upper = std::max(m_result.upper, farthest);
            return;
        }
        // What lies straight above or below the triangle is as far from it as it is high. The rest
        // has other triangles to look at.
        const TriangleCorners corners = m_tree.corners(nearest.slot);
        const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Polygon above = piece;
        std::vector<Polygon> beside;
        for (std::size_t k = 0; k < 3 && hasArea(above) && normal.squaredNorm() > 0.0; ++k)
        {
            auto [inside, outside] =
                cut(above, corners[k], normal.cross(corners[(k + 1) % 3] - corners[k]));
            if (hasArea(outside))
            {
                beside.push_back(std::move(outside));
            }
            above = std::move(inside);
        }
        // Rounding leaves slivers: a cut that divides nothing else makes no progress.
        constexpr double kSliver = 0.05;
        const double share = areaOf(above) / std::max(areaOf(piece), 1e-300);
        if (share < kSliver || share > 1.0 - kSliver)
        {
            push(halved(piece));
            return;
        }
        m_pieces.push_back(std::move(above));
        std::move(beside.begin(), beside.end(), std::back_inserter(m_pieces));
    }

    const SsvTree& m_tree;
    double m_near;
    double m_limit;
    const StopCondition& m_stop;
    std::int32_t m_guess = kNone;
    std::vector<Polygon> m_pieces;
    Deviation m_result;
};
}  // namespace

Deviation triangleDeviation(const TriangleCorners& triangle,
                            const SsvTree& other,
                            double near,
                            double limit,
                            const StopCondition& stop,
                            std::int32_t& guess)
{
    return TriangleDeviation(other, near, limit, stop).run(triangle, guess);
}

Deviation surfaceDeviation(const TriangleMesh& surface,
                           const SsvTree& other,
                           double enough,
                           double limit,
                           const StopCondition& stop)
{
    checkMesh(surface, "deviation: the surface");
    require(enough >= 0.0 && limit >= 0.0, "deviation: bounds must be numbers >= 0 [m]");
    const auto at = [&](std::int32_t vertex) -> Vector3d
    { return surface.vertices[static_cast<std::size_t>(vertex)] - other.origin(); };

    // Distances of the vertices first: what they show need not be shown again, and a surface that
    // is too far away is so there.
    const std::size_t count = surface.triangles.size();
    std::vector<Nearest> corners(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256),
                      [&](const auto& range)
                      {
                          throwIfDue(stop);
                          std::int32_t guess = kNone;
                          for (std::size_t i = range.begin(); i < range.end(); ++i)
                          {
                              corners[i] =
                                  nearestTriangle(other, at(surface.triangles[i][0]), guess);
                              guess = corners[i].slot;
                          }
                      });
    Deviation result;
    for (std::size_t i = 0; i < count; ++i)
    {
        if (corners[i].distance > result.lower)
        {
            result.lower = corners[i].distance;
            result.point = at(surface.triangles[i][0]) + other.origin();
        }
    }
    if (result.lower > limit)
    {
        result.upper = kInfinity;
        return result;
    }

    const double rounding = 1e-12 * (other.radius() + other.origin().cwiseAbs().maxCoeff());
    const double near = std::max({enough, rounding, (1.0 + kShare) * result.lower});
    std::vector<Deviation> parts(count);
    std::atomic<bool> isTooFar = false;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 64),
                      [&](const auto& range)
                      {
                          for (std::size_t i = range.begin(); i < range.end() && !isTooFar; ++i)
                          {
                              const Triangle& t = surface.triangles[i];
                              parts[i] = TriangleDeviation(other, near, limit, stop)
                                             .run({at(t[0]), at(t[1]), at(t[2])}, corners[i].slot);
                              if (parts[i].lower > limit)
                              {
                                  isTooFar = true;
                              }
                          }
                      });
    result.upper = result.lower;
    for (const Deviation& part : parts)
    {
        result.upper = std::max(result.upper, part.upper);
        if (part.lower > result.lower)
        {
            result.lower = part.lower;
            result.point = part.point + other.origin();
        }
    }
    return result;
}
}  // namespace bullet_ccd
