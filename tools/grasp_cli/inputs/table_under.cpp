#include "tools/grasp_cli/inputs/table_under.h"

#include "bullet_ccd/math/pose.h"

#include <memory>

namespace bullet_ccd::tools
{
namespace
{
/// @param halfExtents  of the box, the last one along `up` [m]
Obstacle boxUnder(const grasp::GraspObject& object,
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
}  // namespace

Obstacle tableUnder(const grasp::GraspObject& object, const Eigen::Vector3d& up)
{
    constexpr double kReach = 1.0;  // of a hand [m]
    constexpr double kDepth = 0.5;  // same
    return boxUnder(object, up, {object.radius + kReach, object.radius + kReach, kDepth});
}

Obstacle shownTableUnder(const grasp::GraspObject& object, const Eigen::Vector3d& up)
{
    constexpr double kThickness = 5e-3;  // of half of it [m]
    return boxUnder(object, up, {1.5 * object.radius, 1.5 * object.radius, kThickness});
}
}  // namespace bullet_ccd::tools
