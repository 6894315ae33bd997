#include "tools/grasp_cli/answers/audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace bullet_ccd::tools
{
namespace
{
double segmentDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
    const Eigen::Vector3d along = b - a;
    const double length = along.squaredNorm();
    const double s = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
    return (p - a - s * along).norm();
}

/// The foot of the perpendicular if it lies inside, else the nearest of the three edges.
double triangleDistance(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& t)
{
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    bool inside = normal.squaredNorm() > 0.0;
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Eigen::Vector3d& a = t[k];
        const Eigen::Vector3d& b = t[(k + 1) % 3];
        inside = inside && normal.dot((b - a).cross(p - a)) >= 0.0;
        distance = std::min(distance, segmentDistance(p, a, b));
    }
    return inside ? std::min(distance, std::abs(normal.normalized().dot(p - t[0]))) : distance;
}

double meshDistance(const Eigen::Vector3d& p, const TriangleMesh& mesh)
{
    double distance = std::numeric_limits<double>::infinity();
    const auto vertex = [&](std::int32_t index) -> const Eigen::Vector3d&
    { return mesh.vertices[static_cast<std::size_t>(index)]; };
    for (const auto& [a, b, c] : mesh.triangles)
    {
        distance = std::min(distance, triangleDistance(p, {vertex(a), vertex(b), vertex(c)}));
    }
    return distance;
}
}  // namespace

GraspAudit auditGrasp(const grasp::HandModel& hand,
                      const grasp::GraspObject& object,
                      const grasp::Grasp& grasp)
{
    GraspAudit audit;
    audit.penetration = grasp::checkPenetration(hand, object, grasp.X_WH, grasp.positions);
    const std::vector<Eigen::Isometry3d> X_WL =
        linkPoses(hand.robot.tree, grasp.X_WH, grasp.positions);
    std::set<std::int32_t> links;
    for (const grasp::GraspContact& contact : grasp.contacts)
    {
        const auto link = static_cast<std::size_t>(contact.link);
        audit.largestGap = std::max(
            audit.largestGap,
            meshDistance(X_WL[link].inverse() * contact.point, hand.linkTrees[link]->mesh()));
        audit.largestOffset =
            std::max(audit.largestOffset, meshDistance(contact.point, object.tree.mesh()));
        links.insert(contact.link);
    }
    audit.links = static_cast<int>(links.size());
    audit.fingers = static_cast<int>(std::count_if(
        hand.fingers.begin(),
        hand.fingers.end(),
        [&](const grasp::Finger& finger)
        {
            return std::any_of(finger.links.begin(),
                               finger.links.end(),
                               [&](std::int32_t link) { return links.contains(link); });
        }));
    return audit;
}
}  // namespace bullet_ccd::tools
