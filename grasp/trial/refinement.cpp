#include "grasp/trial/refinement.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Turns about the point, then moves.
Eigen::Isometry3d movedBy(const Eigen::Vector3d& point,
                          const Eigen::AngleAxisd& turn,
                          const Eigen::Vector3d& shift)
{
    Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
    moved.translate(point + shift);
    moved.rotate(turn);
    moved.translate(-point);
    return moved;
}

/// What the hand may be moved by.
std::vector<Eigen::Isometry3d> moves(const GraspObject& object,
                                     const Grasp& grasp,
                                     const TrialResult& result)
{
    const Eigen::Vector3d center = object.centerOfMass;
    Eigen::Vector3d across = Eigen::Vector3d::Zero();
    for (const GraspContact& contact : grasp.contacts)
    {
        across += (center - contact.point) / static_cast<double>(grasp.contacts.size());
    }
    across -= across.dot(grasp.approach_W) * grasp.approach_W;
    std::vector<Eigen::Isometry3d> found;
    for (const double share : {1.0, 0.5})
    {
        Eigen::AngleAxisd turn(result.moved.linear());
        turn.angle() *= share;
        const Eigen::Vector3d slip = result.moved * center - center;
        found.push_back(movedBy(center, turn, share * slip).inverse());
        found.emplace_back(Eigen::Translation3d(share * across));
    }
    return found;
}
}  // namespace

Grasp refinedGrasp(const HandModel& hand,
                   const GraspObject& object,
                   const Grasp& grasp,
                   const TrialResult& result,
                   const PlannerOptions& options,
                   const CloseHand& close,
                   std::span<const RigidBody> obstacles)
{
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    require(preshape != nullptr,
            "refinedGrasp: the hand has no preshape \"" + grasp.preshape +
                "\" of the grasp's name: give the SRDF that the grasp was planned with");
    PlannerOptions closing = options;
    closing.centred = true;
    closing.volumes = std::max(1, options.volumes);  // without one the mass is not looked for
    const Eigen::Vector3d way = grasp.X_WH.translation() - grasp.X_WStart.translation();
    Grasp best;
    best.reject = RejectReason::NoForceClosure;
    for (const Eigen::Isometry3d& move : moves(object, grasp, result))
    {
        Grasp tried = closeAtPose(hand,
                                  object,
                                  move * grasp.X_WStart,
                                  move.linear() * way,
                                  *preshape,
                                  closing,
                                  close,
                                  obstacles);
        if (tried.reject == RejectReason::None &&
            (best.reject != RejectReason::None ||
             tried.quality.largestMass > best.quality.largestMass))
        {
            best = std::move(tried);
        }
    }
    best.candidate = grasp.candidate;
    best.source = grasp.source;
    return best;
}
}  // namespace bullet_ccd::grasp
