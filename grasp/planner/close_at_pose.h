/// Closing at a pose that the caller chooses, instead of at sampled candidates.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/approach/approach_motion.h"
#include "grasp/planner/grasp_planner.h"

namespace bullet_ccd::grasp
{
/// Moves the open hand from X_WStart along `shift` (W [m], may be zero) until its first contact or
/// the end of the shift. Then closes it there once and scores what it holds. Nothing is sampled,
/// retreated or centred.
///
/// The reject reasons, in the order in which they are looked for, are OverlapAtStart (by the
/// independent check), SelfOverlap, IterationLimit (then the hand was not closed, and there are no
/// joint positions), Penetration, TooFewContacts and NoForceClosure.
/// @param options  only those of closing, contacts and quality are used
[[nodiscard]] BULLET_CCD_API Grasp closeAtPose(const HandModel& hand,
                                               const GraspObject& object,
                                               const Eigen::Isometry3d& X_WStart,
                                               const Eigen::Vector3d& shift,
                                               const Preshape& preshape,
                                               const PlannerOptions& options,
                                               const CloseHand& close);

/// A grasp at the end of a path, and how far the hand got.
struct PathGrasp
{
    PathApproach way;
    Grasp grasp;
};

/// The same after the open hand has moved along a path of poses of its root link (W) until its
/// first contact or the end of the path; see approachUntilContact(). The start of the grasp is the
/// first pose. Its direction and distance of approach are those of the straight line from there to
/// where the hand closes.
/// Throws std::invalid_argument for a path without a pose.
[[nodiscard]] BULLET_CCD_API PathGrasp closeOnPath(const HandModel& hand,
                                                   const GraspObject& object,
                                                   std::span<const Eigen::Isometry3d> path,
                                                   const Preshape& preshape,
                                                   const PlannerOptions& options,
                                                   const CloseHand& close);
}  // namespace bullet_ccd::grasp
