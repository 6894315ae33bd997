#include "grasp/planner/close_at_pose.h"

#include "grasp/approach/approach_motion.h"
#include "grasp/planner/penetration_check.h"
#include "grasp/planner/plan_candidate.h"

#include <array>

namespace bullet_ccd::grasp
{
namespace
{
/// Why the open hand cannot be here, or None.
RejectReason overlapAtStart(const CandidateContext& context,
                            const Eigen::Isometry3d& X_WH,
                            const std::vector<double>& positions)
{
    if (!context.check.at(X_WH, positions).clean())
    {
        return RejectReason::OverlapAtStart;
    }
    return handOverlaps(context.hand, context.object, X_WH, positions) ? RejectReason::SelfOverlap
                                                                       : RejectReason::None;
}

/// Moves grasp.X_WH along the shift until the first contact; sets what the approach leaves behind.
void approach(Grasp& grasp,
              const Eigen::Vector3d& shift,
              const std::vector<double>& positions,
              CandidateContext& context)
{
    const ArticulatedToiResult result = approachUntilContact(context.hand,
                                                             context.environment,
                                                             grasp.X_WStart,
                                                             positions,
                                                             shift,
                                                             context.options.closing.tolerance,
                                                             context.work);
    grasp.reject = rejectReasonOf(result.status, RejectReason::OverlapAtStart);
    const double travelled = result.status == ToiStatus::Separated ? 1.0 : result.time;
    grasp.approach_W = shift.normalized();
    grasp.approachDistance = travelled * shift.norm();
    grasp.X_WH.translation() += travelled * shift;
}
}  // namespace

Grasp closeAtPose(const HandModel& hand,
                  const GraspObject& object,
                  const Eigen::Isometry3d& X_WStart,
                  const Eigen::Vector3d& shift,
                  const Preshape& preshape,
                  const PlannerOptions& options,
                  const CloseHand& close)
{
    Grasp grasp;
    grasp.preshape = preshape.name;
    grasp.X_WStart = X_WStart;
    grasp.X_WH = X_WStart;
    PenetrationCheck check(hand, object);
    const std::array bodies{RigidBody{.tree = &object.tree, .motion = {}}};
    const Environment environment(bodies);
    ToiWorkspace work;
    CandidateContext context{.hand = hand,
                             .object = object,
                             .environment = environment,
                             .options = options,
                             .close = close,
                             .check = check,
                             .work = work};
    grasp.reject = overlapAtStart(context, X_WStart, preshape.positions);
    if (grasp.reject != RejectReason::None)
    {
        return grasp;
    }
    if (!shift.isZero(0.0))
    {
        approach(grasp, shift, preshape.positions, context);
    }
    if (grasp.reject == RejectReason::None)
    {
        const Eigen::Isometry3d X_WH = grasp.X_WH;
        closeAndScore(grasp, X_WH, preshape.positions, context);
        rejectPenetration(grasp, context);
        if (options.volumes > 0)
        {
            addVolume(grasp, object, options);
        }
    }
    return grasp;
}
}  // namespace bullet_ccd::grasp
