#include "grasp/check/closed_surface.h"

#include "bullet_ccd/math/pose.h"
#include "grasp/check/sign_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// Rays in no special direction; the next one is taken where a ray grazes an edge or a corner.
constexpr std::array<std::array<double, 3>, 4> kRays = {{{0.2718, -0.5772, 0.7693},
                                                         {-0.6180, 0.3217, 0.7173},
                                                         {0.4142, 0.8431, -0.3429},
                                                         {-0.1931, -0.2236, -0.9553}}};

Corners cornersOf(const std::vector<Eigen::Vector3d>& vertices, const Triangle& triangle)
{
    return {vertices[static_cast<std::size_t>(triangle[0])],
            vertices[static_cast<std::size_t>(triangle[1])],
            vertices[static_cast<std::size_t>(triangle[2])]};
}

/// What a ray adds to the winding number: +1 where it leaves, -1 where it enters; nothing if that
/// is not certain. `turnedPoint` and `turnedTriangle` are seen along the ray, and consistent for
/// triangles that share an edge; which side the point is on is decided on the given coordinates,
/// that have not been rounded by turning.
std::optional<int> rayCrossing(const Eigen::Vector3d& turnedPoint,
                               const Corners& turnedTriangle,
                               const Eigen::Vector3d& point,
                               const Corners& triangle)
{
    const auto& [a, b, c] = turnedTriangle;
    const std::array<int, 3> turns = {
        orient2d(a, b, turnedPoint), orient2d(b, c, turnedPoint), orient2d(c, a, turnedPoint)};
    const auto [low, high] = std::minmax({turns[0], turns[1], turns[2]});
    if (low < 0 && high > 0)
    {
        return 0;
    }
    const int side = orient3d(triangle[0], triangle[1], triangle[2], point);
    if (low != high || low == 0 || side == 0)
    {
        return std::nullopt;
    }
    return side == low ? low : 0;  // else the triangle is behind the start of the ray
}
}  // namespace

ClosedSurface::Turned ClosedSurface::turned(const Eigen::Vector3d& rayDirection) const
{
    const Eigen::Matrix3d turn =
        rotationBetween(rayDirection, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    std::vector<Eigen::Vector3d> vertices;
    vertices.reserve(m_mesh->vertices.size());
    for (const Eigen::Vector3d& vertex : m_mesh->vertices)
    {
        vertices.emplace_back(turn * vertex);
    }
    std::vector<Eigen::AlignedBox3d> boxes;
    boxes.reserve(m_mesh->triangles.size());
    for (const Triangle& triangle : m_mesh->triangles)
    {
        Eigen::AlignedBox3d& box = boxes.emplace_back();
        for (Eigen::Vector3d corner : cornersOf(vertices, triangle))
        {
            corner.z() = 0.0;
            box.extend(corner);
        }
    }
    return {turn, std::move(vertices), BoxGrid(std::move(boxes))};
}

bool ClosedSurface::contains(const Eigen::Vector3d& point)
{
    for (std::size_t ray = 0; ray < kRays.size(); ++ray)
    {
        if (m_turned.size() <= ray)
        {
            m_turned.push_back(turned(Eigen::Vector3d(kRays[ray].data())));
        }
        Turned& mesh = m_turned[ray];
        const Eigen::Vector3d start = mesh.turn * point;
        const Eigen::Vector3d shadow(start.x(), start.y(), 0.0);
        mesh.shadow.query(Eigen::AlignedBox3d(shadow, shadow), m_found);
        std::optional<int> winding = 0;
        for (std::size_t i = 0; i < m_found.size() && winding; ++i)
        {
            const Triangle& triangle = m_mesh->triangles[static_cast<std::size_t>(m_found[i])];
            const std::optional<int> step = rayCrossing(start,
                                                        cornersOf(mesh.vertices, triangle),
                                                        point,
                                                        cornersOf(m_mesh->vertices, triangle));
            winding = step ? std::optional(*winding + *step) : std::nullopt;
        }
        if (winding)
        {
            return *winding != 0;
        }
    }
    return false;
}

double ClosedSurface::distance(const Eigen::Vector3d& point) const
{
    double best = std::numeric_limits<double>::infinity();
    for (const Triangle& triangle : m_mesh->triangles)
    {
        const Corners corners = cornersOf(m_mesh->vertices, triangle);
        // No point of the triangle is farther from its first corner than `reach`.
        const double reach = std::sqrt(std::max((corners[1] - corners[0]).squaredNorm(),
                                                (corners[2] - corners[0]).squaredNorm()));
        if ((point - corners[0]).norm() - reach < best)
        {
            best = std::min(best, pointTriangleDistance(point, corners));
        }
    }
    return best;
}
}  // namespace bullet_ccd::grasp
