#include "tools/grasp_cli/inputs/table_under.h"

#include "bullet_ccd/math/pose.h"

#include <memory>

namespace bullet_ccd::tools
{
Obstacle tableUnder(const grasp::GraspObject& object,
                    const Eigen::Vector3d& up,
                    const Eigen::Vector3d& halfExtents)
{
    const Eigen::Vector3d axis = up.normalized();
    const Eigen::Vector3d& center = object.centerOfMass;
    const double top = grasp::lowestHeight(object.tree, Eigen::Isometry3d::Identity(), axis);
    Obstacle table{.name = "table",
                   .tree = std::make_shared<const SsvTree>(buildSsvTree(makeBox(halfExtents)))};
    table.X_WO.rotate(rotationBetween(Eigen::Vector3d::UnitZ(), axis));
    table.X_WO.translation() = center + (top - halfExtents.z() - center.dot(axis)) * axis;
    return table;
}

Obstacle tableUnder(const grasp::GraspObject& object, const Eigen::Vector3d& up)
{
    constexpr double kReach = 1.0;  // of a hand [m]
    constexpr double kDepth = 0.5;  // same
    return tableUnder(object, up, {object.radius + kReach, object.radius + kReach, kDepth});
}
}  // namespace bullet_ccd::tools
