/// One candidate from the start of its approach to its quality.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/planner/grasp_planner.h"

namespace bullet_ccd::grasp
{
/// What a candidate needs besides itself.
struct CandidateContext
{
    const HandModel& hand;
    const GraspObject& object;
    const Environment& environment;  ///< the object
    const PlannerOptions& options;
    const CloseHand& close;
    ToiWorkspace& work;
};

/// Contacts of all links with the object at a fixed posture: features within
/// options.closing.contactThreshold, those of one link nearer than options.minContactSpacing to one
/// that is kept left out (the closest is kept). Ordered by link.
[[nodiscard]] std::vector<GraspContact> collectContacts(const HandModel& hand,
                                                        const GraspObject& object,
                                                        const Eigen::Isometry3d& X_WH,
                                                        std::span<const double> positions,
                                                        const PlannerOptions& options);

/// Approaches until the first contact, closes there and at poses a little farther back (and, if the
/// hand got past the middle of the object, at the middle), and keeps the grasp with the largest
/// epsilon.
[[nodiscard]] Grasp planCandidate(const ApproachCandidate& candidate, CandidateContext& context);
}  // namespace bullet_ccd::grasp
