#include "grasp/closing/closing.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
const char* toString(ClosingEngine engine)
{
    return engine == ClosingEngine::Kinematic ? "kinematic" : "simulated";
}

const char* toString(ClosingOrder order)
{
    return order == ClosingOrder::Together ? "together" : "one-by-one";
}

namespace
{
/// Surfaces closer than this cannot be told from intersecting ones in double precision [m].
constexpr double kOverlap = 1e-12;
}  // namespace

bool handOverlaps(const HandModel& hand,
                  const GraspObject& object,
                  const Eigen::Isometry3d& X_WH,
                  const std::vector<double>& positions)
{
    const std::vector<Eigen::Isometry3d> X_WL = linkPoses(hand.robot.tree, X_WH, positions);
    const auto overlap = [](const SsvTree* a, const SsvTree* b, const Eigen::Isometry3d& X_BA)
    {
        return a != nullptr && b != nullptr &&
               treeDistance(*a, *b, X_BA, kOverlap).distance < kOverlap;
    };
    for (std::size_t i = 0; i < X_WL.size(); ++i)
    {
        if (overlap(hand.linkTrees[i], &object.tree, X_WL[i]))
        {
            return true;
        }
    }
    return std::any_of(hand.selfPairs.begin(),
                       hand.selfPairs.end(),
                       [&](const auto& pair)
                       {
                           const auto a = static_cast<std::size_t>(pair.first);
                           const auto b = static_cast<std::size_t>(pair.second);
                           return overlap(
                               hand.linkTrees[a], hand.linkTrees[b], X_WL[b].inverse() * X_WL[a]);
                       });
}
}  // namespace bullet_ccd::grasp
