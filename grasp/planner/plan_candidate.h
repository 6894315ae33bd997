/// One candidate from the start of its approach to its quality.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/check/penetration_check.h"
#include "grasp/closing/swept_boxes.h"
#include "grasp/planner/grasp_planner.h"

namespace bullet_ccd::grasp
{
/// What a candidate needs besides itself.
struct CandidateContext
{
    const HandModel& hand;
    const GraspObject& object;
    const Environment& environment;  ///< the object, and what else is near
    const PlannerOptions& options;
    const CloseHand& close;
    PenetrationCheck& check;
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

/// How near to the truth epsilon of exact cones is, from below: absolutely, or as a part of it.
inline constexpr double kEpsilonResolution = 1e-4;
inline constexpr double kEpsilonShare = 0.01;

/// Of the contacts, about the object's centre of mass, with exact friction cones
/// (kEpsilonResolution) or with the pyramids that the options ask for.
[[nodiscard]] double epsilonOf(const Grasp& grasp,
                               const GraspObject& object,
                               const PlannerOptions& options);

/// Edges of the friction pyramids of all contacts, about the object's centre of mass.
[[nodiscard]] std::vector<Wrench> wrenchesOf(const Grasp& grasp,
                                             const GraspObject& object,
                                             const PlannerOptions& options);

/// Gives a force closure the volume of its wrench space, which takes far longer than epsilon.
void addVolume(Grasp& grasp, const GraspObject& object, const PlannerOptions& options);

/// What the outcome of a query rejects; `overlap` is the reason for one that began in an overlap.
[[nodiscard]] RejectReason rejectReasonOf(ToiStatus status, RejectReason overlap);

/// Closes at X_WH from joint positions `preshape` and scores what comes out; `grasp` brings what is
/// known from the approach. A grasp that was not closed is left without joint positions.
/// @pre the open hand is clear of the object at X_WH: what overlaps there is taken to be the hand
void closeAndScore(Grasp& grasp,
                   const Eigen::Isometry3d& X_WH,
                   const std::vector<double>& preshape,
                   CandidateContext& context);

/// Closes at one pose. Jaws on one motor that touch on one side then go sideways by half of what is
/// free there, if the open hand can, and close again, as long as that makes the grasp better.
[[nodiscard]] Grasp closeCentred(const Grasp& approached,
                                 const Eigen::Isometry3d& X_WH,
                                 const std::vector<double>& preshape,
                                 CandidateContext& context);

/// Rejects a closed grasp that intersects the object. Its contacts say whether surfaces are apart;
/// only where they are not, or where one is inside the other, the independent check decides.
void rejectPenetration(Grasp& grasp, const CandidateContext& context);

/// Obstacles, and where the hand can get from each of its preshapes.
struct Surroundings
{
    std::span<const RigidBody> obstacles{};
    std::vector<SweptBoxes> boxes{};  ///< one a preshape, if there are obstacles
};

/// The object first, then those obstacles that the candidate can reach on its way.
[[nodiscard]] std::vector<RigidBody> bodiesNear(const ApproachCandidate& candidate,
                                                const GraspObject& object,
                                                const Surroundings& surroundings);

/// Approaches until the first contact, closes there and at poses a little farther back (and, if the
/// hand got past the middle of the object, at the middle; jaws on one motor also at other depths),
/// until one is a force closure, and keeps the grasp with the largest epsilon.
[[nodiscard]] Grasp planCandidate(const ApproachCandidate& candidate, CandidateContext& context);
}  // namespace bullet_ccd::grasp
