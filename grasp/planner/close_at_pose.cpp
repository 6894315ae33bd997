#include "bullet_ccd/math/check.h"
#include "grasp/check/penetration_check.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/planner/plan_candidate.h"
#include "grasp/planner/weight_margin.h"

#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Index in the environment; obstacles come after it.
constexpr std::int32_t kTheObject = 0;

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
    if (!result.contacts.empty() && result.contacts.front().obstacle > kTheObject)
    {
        grasp.reject = RejectReason::Obstacle;
    }
    const double travelled = result.status == ToiStatus::Separated ? 1.0 : result.time;
    grasp.approach_W = shift.normalized();
    grasp.approachDistance = travelled * shift.norm();
    grasp.X_WH.translation() += travelled * shift;
}

/// Moves grasp.X_WH along the path until the first contact; sets what the approach leaves behind.
PathApproach follow(Grasp& grasp,
                    std::span<const Eigen::Isometry3d> path,
                    const std::vector<double>& positions,
                    CandidateContext& context)
{
    PathApproach way = approachUntilContact(context.hand,
                                            context.environment,
                                            path,
                                            positions,
                                            context.options.closing.tolerance,
                                            context.work);
    grasp.reject = rejectReasonOf(way.status, RejectReason::OverlapAtStart);
    grasp.X_WH = way.X_WH;
    const Eigen::Vector3d moved = way.X_WH.translation() - path.front().translation();
    grasp.approachDistance = moved.norm();
    if (grasp.approachDistance > 0.0)
    {
        grasp.approach_W = moved / grasp.approachDistance;
    }
    return way;
}

/// Calls move(grasp, context) with the open hand at X_WStart, and closes it where that leaves it.
template <typename Move>
Grasp closeAfter(const Move& move,
                 const HandModel& hand,
                 const GraspObject& object,
                 const Eigen::Isometry3d& X_WStart,
                 const Preshape& preshape,
                 const PlannerOptions& options,
                 const CloseHand& close,
                 std::span<const RigidBody> obstacles)
{
    Grasp grasp;
    grasp.preshape = preshape.name;
    grasp.X_WStart = X_WStart;
    grasp.X_WH = X_WStart;
    PenetrationCheck check(hand, object);
    std::vector<RigidBody> bodies{{.tree = &object.tree, .motion = {}}};
    bodies.insert(bodies.end(), obstacles.begin(), obstacles.end());
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
    move(grasp, context);
    if (grasp.reject == RejectReason::None)
    {
        const Eigen::Isometry3d X_WH = grasp.X_WH;
        if (options.centred)
        {
            grasp = closeCentred(grasp, X_WH, preshape.positions, context);
        }
        else
        {
            closeAndScore(grasp, X_WH, preshape.positions, context);
        }
        if (!grasp.positions.empty() && !check.at(grasp.X_WH, grasp.positions).clean())
        {
            grasp.reject = RejectReason::Penetration;
        }
        if (options.volumes > 0)
        {
            addVolume(grasp, object, options);
            if (grasp.reject == RejectReason::None)
            {
                grasp.quality.largestMass = largestMassHeld(
                    hand, object, grasp, options.friction, pyramidEdges(options), options.efforts);
            }
        }
    }
    return grasp;
}
}  // namespace

Grasp closeAtPose(const HandModel& hand,
                  const GraspObject& object,
                  const Eigen::Isometry3d& X_WStart,
                  const Eigen::Vector3d& shift,
                  const Preshape& preshape,
                  const PlannerOptions& options,
                  const CloseHand& close,
                  std::span<const RigidBody> obstacles)
{
    const auto move = [&](Grasp& grasp, CandidateContext& context)
    {
        if (!shift.isZero(0.0))
        {
            approach(grasp, shift, preshape.positions, context);
        }
    };
    return closeAfter(move, hand, object, X_WStart, preshape, options, close, obstacles);
}

PathGrasp closeOnPath(const HandModel& hand,
                      const GraspObject& object,
                      std::span<const Eigen::Isometry3d> path,
                      const Preshape& preshape,
                      const PlannerOptions& options,
                      const CloseHand& close,
                      std::span<const RigidBody> obstacles)
{
    require(!path.empty(), "closeOnPath: the path has no pose");
    PathGrasp result{.way = {.status = ToiStatus::Overlapping, .time = 0.0, .X_WH = path.front()},
                     .grasp = {}};
    const auto move = [&](Grasp& grasp, CandidateContext& context)
    { result.way = follow(grasp, path, preshape.positions, context); };
    result.grasp =
        closeAfter(move, hand, object, path.front(), preshape, options, close, obstacles);
    return result;
}
}  // namespace bullet_ccd::grasp
