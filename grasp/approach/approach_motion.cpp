#include "grasp/approach/approach_motion.h"

namespace bullet_ccd::grasp
{
ArticulatedToiResult approachUntilContact(const HandModel& hand,
                                          const Environment& environment,
                                          const Eigen::Isometry3d& X_WH,
                                          const std::vector<double>& positions,
                                          const Eigen::Vector3d& shift,
                                          double tolerance,
                                          ToiWorkspace& work)
{
    const JointMotion motion{.root = {.X_W0 = X_WH, .v_W = shift},
                             .positions = positions,
                             .rates = std::vector<double>(positions.size(), 0.0)};
    const ArticulatedBody body{
        .tree = &hand.robot.tree, .linkTrees = hand.linkTrees, .motion = &motion, .selfPairs = {}};
    return articulatedToi(body, environment, {.toi = {.tolerance = tolerance, .aim = 0.5}}, work);
}
}  // namespace bullet_ccd::grasp
