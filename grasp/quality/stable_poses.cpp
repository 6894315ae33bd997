#include "grasp/quality/stable_poses.h"

#include "bullet_ccd/reduce/qhull_state.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace bullet_ccd::grasp
{
namespace
{
/// How far from the plane what touches it may be, of the radius of the object.
constexpr double kTouching = 1e-3;
/// Cosine of 3 degrees.
constexpr double kSameFace = 0.99863;

using Points2 = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    return a.x() * b.y() - a.y() * b.x();
}

/// Corners of the convex hull, counter-clockwise: Andrew's monotone chain.
Points2 hullOf(Points2 points)
{
    std::ranges::sort(points,
                      [](const auto& a, const auto& b)
                      { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
    Points2 hull;
    for (int half = 0; half < 2; ++half)
    {
        const std::size_t first = hull.size();
        for (const Eigen::Vector2d& point : points)
        {
            while (hull.size() >= first + 2 &&
                   cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0.0)
            {
                hull.pop_back();
            }
            hull.push_back(point);
        }
        hull.pop_back();
        std::ranges::reverse(points);
    }
    return hull;
}

/// How far the origin is inside of the convex hull; negative outside.
double insideBy(const Points2& points)
{
    const Points2 hull = hullOf(points);
    double least = hull.size() < 3 ? -1.0 : std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size() && hull.size() >= 3; ++i)
    {
        const Eigen::Vector2d& a = hull[i];
        const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - a;
        least = std::min(least, cross(edge, -a) / edge.norm());
    }
    return least;
}

/// The tilt at which the object tips off the plane below it; negative where it does at once.
double tiltOn(const GraspObject& object,
              const std::vector<Eigen::Vector3d>& corners,
              const Eigen::Vector3d& down)
{
    const Eigen::Vector3d x = down.unitOrthogonal();
    const Eigen::Vector3d y = down.cross(x);
    double lowest = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& corner : corners)
    {
        lowest = std::max(lowest, down.dot(corner));
    }
    Points2 touching;
    for (const Eigen::Vector3d& corner : corners)
    {
        if (down.dot(corner) >= lowest - kTouching * object.radius)
        {
            const Eigen::Vector3d arm = corner - object.centerOfMass;
            touching.emplace_back(x.dot(arm), y.dot(arm));
        }
    }
    return std::atan2(insideBy(touching), lowest - down.dot(object.centerOfMass));
}
}  // namespace

std::vector<StablePose> stablePoses(const GraspObject& object, double leastTilt)
{
    std::vector<double> coordinates;
    for (const Eigen::Vector3d& vertex : object.tree.mesh().vertices)
    {
        coordinates.insert(coordinates.end(), vertex.data(), vertex.data() + 3);
    }
    QhullState hull;
    char options[] = "qhull Pp";  // no reports of precision
    std::vector<StablePose> all;
    if (!hull.build(
            options, coordinates.data(), 3, static_cast<int>(object.tree.mesh().vertices.size())))
    {
        return all;
    }
    std::vector<Eigen::Vector3d> corners;
    for (const vertexT* vertex = hull.state().vertex_list;
         vertex != nullptr && vertex->next != nullptr;
         vertex = vertex->next)
    {
        corners.emplace_back(Eigen::Map<const Eigen::Vector3d>(vertex->point));
    }
    for (const facetT* facet = hull.state().facet_list; facet != nullptr && facet->next != nullptr;
         facet = facet->next)
    {
        const Eigen::Vector3d down = Eigen::Map<const Eigen::Vector3d>(facet->normal).normalized();
        if (const double tilt = tiltOn(object, corners, down); tilt >= leastTilt)
        {
            all.push_back({down, tilt});
        }
    }
    std::ranges::stable_sort(all, std::greater{}, &StablePose::tilt);
    std::vector<StablePose> poses;
    for (const StablePose& pose : all)
    {
        if (std::ranges::none_of(poses,
                                 [&](const StablePose& other)
                                 { return pose.down.dot(other.down) > kSameFace; }))
        {
            poses.push_back(pose);
        }
    }
    return poses;
}
}  // namespace bullet_ccd::grasp
