/// One pose that somebody chose, instead of sampled candidates.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/approach/approach_motion.h"
#include "grasp/planner/grasp_planner.h"

namespace bullet_ccd::grasp
{
/// Moves the open hand from X_WStart along `shift` (W [m], may be zero) until its first contact,
/// but no farther, closes it there once and scores what it holds. Nothing is sampled, retreated or
/// centred: what comes out is what closing at this pose gives.
///
/// Reject reasons, in the order in which they are found: OverlapAtStart (the open hand intersects
/// the object, by the independent check), SelfOverlap, IterationLimit (the hand was not closed:
/// there are no joint positions); then Penetration, TooFewContacts, NoForceClosure or none.
/// @param options  closing, contacts and quality of these are used
[[nodiscard]] BULLET_CCD_API Grasp closeAtPose(const HandModel& hand,
                                               const GraspObject& object,
                                               const Eigen::Isometry3d& X_WStart,
                                               const Eigen::Vector3d& shift,
                                               const Preshape& preshape,
                                               const PlannerOptions& options,
                                               const CloseHand& close);

/// A grasp at the end of a path, and how far along the hand got.
struct PathGrasp
{
    PathApproach way;
    Grasp grasp;
};

/// The same after the open hand has moved along a path of poses of its root link (W), until its
/// first contact or the end: see approachUntilContact(). The grasp has its start at the first pose;
/// its direction and distance of approach are those of the straight line to where the hand closes.
/// Throws std::invalid_argument for a path without a pose.
[[nodiscard]] BULLET_CCD_API PathGrasp closeOnPath(const HandModel& hand,
                                                   const GraspObject& object,
                                                   std::span<const Eigen::Isometry3d> path,
                                                   const Preshape& preshape,
                                                   const PlannerOptions& options,
                                                   const CloseHand& close);
}  // namespace bullet_ccd::grasp
