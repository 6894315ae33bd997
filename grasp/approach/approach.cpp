#include "grasp/approach/approach.h"

#include "bullet_ccd/math/check.h"

#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
ArticulatedToiResult moveUntilContact(const HandModel& hand,
                                      const Environment& environment,
                                      const RigidMotion& root,
                                      const std::vector<double>& positions,
                                      double tolerance,
                                      ToiWorkspace& work)
{
    const JointMotion motion{
        .root = root, .positions = positions, .rates = std::vector<double>(positions.size(), 0.0)};
    const ArticulatedBody body{
        .tree = &hand.robot.tree, .linkTrees = hand.linkTrees, .motion = &motion, .selfPairs = {}};
    const ToiOptions toi{
        .tolerance = tolerance, .aim = 0.5, .anyWithin = tolerance > kDefaultTolerance};
    return articulatedToi(body, environment, {.toi = toi}, work);
}
}  // namespace

ArticulatedToiResult approachUntilContact(const HandModel& hand,
                                          const Environment& environment,
                                          const Eigen::Isometry3d& X_WH,
                                          const std::vector<double>& positions,
                                          const Eigen::Vector3d& shift,
                                          double tolerance,
                                          ToiWorkspace& work)
{
    return moveUntilContact(
        hand, environment, {.X_W0 = X_WH, .v_W = shift}, positions, tolerance, work);
}

PathApproach approachUntilContact(const HandModel& hand,
                                  const Environment& environment,
                                  std::span<const Eigen::Isometry3d> path,
                                  const std::vector<double>& positions,
                                  double tolerance,
                                  ToiWorkspace& work)
{
    require(!path.empty(), "approachUntilContact: the path has no pose");
    PathApproach way{.X_WH = path.front()};
    for (std::size_t leg = 0; leg + 1 < path.size(); ++leg)
    {
        const RigidMotion root = motionBetween(path[leg], path[leg + 1]);
        ArticulatedToiResult result =
            moveUntilContact(hand, environment, root, positions, tolerance, work);
        const bool ends = isContact(result.status) || gaveUp(result.status);
        way.status = result.status;
        way.leg = leg;
        way.time = ends ? result.time : 1.0;
        way.contacts = std::move(result.contacts);
        way.length += way.time * root.v_W.norm();
        if (ends)
        {
            way.X_WH = root.at(way.time).X_W;
            break;
        }
        way.X_WH = path[leg + 1];
    }
    return way;
}
}  // namespace bullet_ccd::grasp
