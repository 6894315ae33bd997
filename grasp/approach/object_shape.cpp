#include "grasp/approach/object_shape.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
using TriangleCorners = std::array<Eigen::Vector3d, 3>;

TriangleCorners cornersOf(const TriangleMesh& mesh, const Triangle& triangle)
{
    const auto vertex = [&](std::int32_t index)
    { return mesh.vertices[static_cast<std::size_t>(index)]; };
    return {vertex(triangle[0]), vertex(triangle[1]), vertex(triangle[2])};
}

struct SurfaceMoments
{
    double area = 0.0;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

SurfaceMoments surfaceMoments(const TriangleMesh& mesh)
{
    SurfaceMoments moments;
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Triangle& triangle : mesh.triangles)
    {
        const auto [a, b, c] = cornersOf(mesh, triangle);
        const double area = 0.5 * (b - a).cross(c - a).norm();
        const Eigen::Vector3d sum = a + b + c;
        moments.area += area;
        moments.center += area / 3.0 * sum;
        // Exact second moment of a triangle: area / 12 (sum of squares of corners + square of sum).
        second +=
            area / 12.0 *
            (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
    if (moments.area > 0.0)
    {
        moments.center /= moments.area;
        moments.covariance = second / moments.area - moments.center * moments.center.transpose();
    }
    return moments;
}

/// Eigenvectors come with either sign; the answer must not depend on the solver's mood.
Eigen::Vector3d withFixedSign(const Eigen::Vector3d& axis)
{
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    return axis[largest] < 0.0 ? Eigen::Vector3d(-axis) : axis;
}

/// The outermost surfaces on a line along x.
struct RaySpan
{
    double lower = std::numeric_limits<double>::infinity();
    double upper = -std::numeric_limits<double>::infinity();
    Eigen::Vector3d normalAtLower = Eigen::Vector3d::Zero();  ///< unit, n_x <= 0
    Eigen::Vector3d normalAtUpper = Eigen::Vector3d::Zero();  ///< unit, n_x >= 0
};

/// The 3 x 3 lines along x, through (y, z) = `spacing` times -1, 0 or 1 each.
struct RayGrid
{
    double spacing;

    /// The coordinate of the lines, in either direction, that is nearest to `at`.
    [[nodiscard]] double nearest(double at) const
    {
        return at > 0.5 * spacing ? spacing : (at < -0.5 * spacing ? -spacing : 0.0);
    }

    /// Calls visit(number, place) for all lines through the rectangle.
    template <typename Visit>
    void forLinesIn(const Eigen::Vector2d& lower,
                    const Eigen::Vector2d& upper,
                    const Visit& visit) const
    {
        for (int line = 0; line < LocalWidth::kRays; ++line)
        {
            const double x = spacing * (line % 3 - 1);
            const double y = spacing * (line / 3 - 1);
            if (x >= lower.x() && x <= upper.x() && y >= lower.y() && y <= upper.y())
            {
                visit(line, Eigen::Vector2d(x, y));
            }
        }
    }
};

/// Extends the span of the line along x through (y, z) = `at` by the triangle, if it meets it.
void extend(RaySpan& span, const TriangleCorners& t, const Eigen::Vector2d& at)
{
    std::array<double, 3> weights{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Eigen::Vector2d p = t[(k + 1) % 3].tail<2>() - at;
        const Eigen::Vector2d q = t[(k + 2) % 3].tail<2>() - at;
        weights[k] = p.x() * q.y() - p.y() * q.x();
    }
    const double sum = weights[0] + weights[1] + weights[2];
    const bool inside = (weights[0] >= 0.0 && weights[1] >= 0.0 && weights[2] >= 0.0) ||
                        (weights[0] <= 0.0 && weights[1] <= 0.0 && weights[2] <= 0.0);
    if (!inside || sum == 0.0)
    {
        return;
    }
    const double x = (weights[0] * t[0].x() + weights[1] * t[1].x() + weights[2] * t[2].x()) / sum;
    // Turned by where it is seen from, because not every mesh is wound outwards.
    const Eigen::Vector3d wound = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    const Eigen::Vector3d normal = wound.x() < 0.0 ? Eigen::Vector3d(-wound) : wound;
    if (x < span.lower)
    {
        span.lower = x;
        span.normalAtLower = -normal;
    }
    if (x > span.upper)
    {
        span.upper = x;
        span.normalAtUpper = normal;
    }
}
}  // namespace

ObjectShape objectShape(const GraspObject& object)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
        surfaceMoments(object.tree.mesh()).covariance);
    Eigen::Matrix3d axes;
    for (int k = 0; k < 3; ++k)
    {
        axes.col(k) = withFixedSign(solver.eigenvectors().col(k));
    }
    Eigen::Vector3d lower = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector3d upper = -lower;
    for (const Eigen::Vector3d& vertex : object.tree.mesh().vertices)
    {
        const Eigen::Vector3d along = axes.transpose() * (vertex - object.centerOfMass);
        lower = lower.cwiseMin(along);
        upper = upper.cwiseMax(along);
    }
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(),
                     order.end(),
                     [&](int i, int j) { return upper[i] - lower[i] > upper[j] - lower[j]; });
    ObjectShape shape;
    for (int k = 0; k < 3; ++k)
    {
        const int from = order[static_cast<std::size_t>(k)];
        shape.axes.col(k) = axes.col(from);
        shape.lower[k] = lower[from];
        shape.upper[k] = upper[from];
    }
    return shape;
}

namespace
{
/// Calls visit(triangle) for all triangles whose bounding balls a line of the grid in G pierces.
template <typename Visit>
void forTrianglesOnGrid(const SsvTree& tree,
                        const Eigen::Isometry3d& X_GW,
                        const RayGrid& grid,
                        const Visit& visit)
{
    // Only where the balls are across the lines counts.
    const Eigen::Matrix<double, 2, 3> across = X_GW.linear().bottomRows<2>();
    const Eigen::Vector2d origin = (X_GW * tree.origin()).tail<2>();
    std::vector<std::int32_t> open{0};
    while (!open.empty())
    {
        const SsvNode& node = tree.nodes()[static_cast<std::size_t>(open.back())];
        open.pop_back();
        const Eigen::Vector2d center =
            across * Eigen::Map<const Eigen::Vector3f>(node.center).cast<double>() + origin;
        const Eigen::Vector2d off(center.x() - grid.nearest(center.x()),
                                  center.y() - grid.nearest(center.y()));
        const double radius = node.size();
        if (off.squaredNorm() > radius * radius)
        {
            continue;
        }
        if (node.isLeaf())
        {
            visit(tree.triangle(node.first));
        }
        tree.open(node);
        for (std::int32_t child = 0; child < node.count; ++child)
        {
            open.push_back(node.first + child);
        }
    }
}
}  // namespace

std::vector<std::int32_t> trianglesNearLine(const SsvTree& tree,
                                            const Eigen::Vector3d& point,
                                            const Eigen::Vector3d& along)
{
    const Eigen::Vector3d across = along.unitOrthogonal();
    Eigen::Isometry3d X_GW = Eigen::Isometry3d::Identity();
    X_GW.linear() << along.transpose(), across.transpose(), along.cross(across).transpose();
    X_GW.translation() = -(X_GW.linear() * point);
    std::vector<std::int32_t> near;
    forTrianglesOnGrid(
        tree, X_GW, RayGrid{0.0}, [&](std::int32_t triangle) { near.push_back(triangle); });
    std::ranges::sort(near);
    return near;
}

LocalWidth localWidth(const GraspObject& object, const Eigen::Isometry3d& X_WG, double spacing)
{
    const Eigen::Isometry3d X_GW = X_WG.inverse();
    const RayGrid grid{spacing};
    std::array<RaySpan, LocalWidth::kRays> spans;
    const TriangleMesh& mesh = object.tree.mesh();
    const auto extendBy = [&](std::int32_t index)
    {
        const auto [a, b, c] = cornersOf(mesh, mesh.triangles[static_cast<std::size_t>(index)]);
        const TriangleCorners t{X_GW * a, X_GW * b, X_GW * c};
        const Eigen::Vector2d lower =
            t[0].tail<2>().cwiseMin(t[1].tail<2>()).cwiseMin(t[2].tail<2>());
        const Eigen::Vector2d upper =
            t[0].tail<2>().cwiseMax(t[1].tail<2>()).cwiseMax(t[2].tail<2>());
        grid.forLinesIn(lower,
                        upper,
                        [&](int line, const Eigen::Vector2d& at)
                        { extend(spans[static_cast<std::size_t>(line)], t, at); });
    };
    forTrianglesOnGrid(object.tree, X_GW, grid, extendBy);
    LocalWidth result;
    Eigen::Vector3d opposition = Eigen::Vector3d::Zero();
    for (const RaySpan& span : spans)
    {
        if (span.lower <= span.upper)
        {
            result.lower = result.hits == 0 ? span.lower : std::min(result.lower, span.lower);
            result.upper = result.hits == 0 ? span.upper : std::max(result.upper, span.upper);
            result.squareness += std::min(-span.normalAtLower.x(), span.normalAtUpper.x());
            opposition += span.normalAtUpper - span.normalAtLower;
            ++result.hits;
        }
    }
    result.squareness /= std::max(1, result.hits);
    if (opposition.norm() > 0.0)
    {
        result.opposition = opposition.normalized();
    }
    return result;
}
}  // namespace bullet_ccd::grasp
