#include "grasp/quality/wrench_space.h"

#include "bullet_ccd/math/check.h"
#include "grasp/quality/hull_about_origin.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
std::vector<Wrench> contactWrenches(std::span<const GraspContact> contacts,
                                    const Eigen::Vector3d& reference,
                                    const WrenchSpaceOptions& options)
{
    require(options.coneEdges >= 3, "wrench space: coneEdges must be at least 3");
    require(options.torqueScale > 0.0, "wrench space: torqueScale must be positive");
    require(options.friction >= 0.0, "wrench space: friction must not be negative");
    std::vector<Wrench> wrenches;
    wrenches.reserve(contacts.size() * static_cast<std::size_t>(options.coneEdges));
    for (const GraspContact& contact : contacts)
    {
        const Eigen::Vector3d tangentA = contact.normal.unitOrthogonal();
        const Eigen::Vector3d tangentB = contact.normal.cross(tangentA);
        const Eigen::Vector3d arm = (contact.point - reference) / options.torqueScale;
        for (int edge = 0; edge < options.coneEdges; ++edge)
        {
            const double phi = 2.0 * std::numbers::pi * edge / options.coneEdges;
            const Eigen::Vector3d force =
                contact.normal +
                options.friction * (std::cos(phi) * tangentA + std::sin(phi) * tangentB);
            Wrench& wrench = wrenches.emplace_back();
            wrench << force, arm.cross(force);
        }
    }
    return wrenches;
}

GraspQuality wrenchSpaceQuality(std::span<const Wrench> wrenches, double forceClosureThreshold)
{
    Eigen::MatrixXd points(6, static_cast<Eigen::Index>(wrenches.size()));
    for (std::size_t i = 0; i < wrenches.size(); ++i)
    {
        points.col(static_cast<Eigen::Index>(i)) = wrenches[i];
    }
    const HullAboutOrigin hull = hullAboutOrigin(points);
    return {.epsilon = hull.radius,
            .volume = hull.volume,
            .forceClosure = hull.radius > 0.0 && hull.radius >= forceClosureThreshold};
}
}  // namespace bullet_ccd::grasp
