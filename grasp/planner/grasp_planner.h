/// Sample, approach, close, score, rank.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/approach/approach_options.h"
#include "grasp/closing/closing.h"
#include "grasp/quality/wrench_space.h"

#include <functional>
#include <span>

namespace bullet_ccd::grasp
{
struct PlannerOptions
{
    std::int64_t candidates = 20;
    std::uint64_t seed = 1;
    int jobs = 0;            ///< threads; 0: one a core. Results do not depend on it.
    double timeLimit = 0.0;  ///< after it no further candidate is begun [s]; 0: none
    ApproachOptions approach = {};
    ClosingOptions closing = {};
    /// That the caller hands to planGrasps(); kept here for the record.
    ClosingEngine engine = ClosingEngine::Kinematic;
    int volumes = 3;  ///< so many of the best grasps get the volume of their wrench space
    double friction = ContactLaw{}.friction;
    int coneEdges = 8;
    double forceClosureThreshold = 0.005;
    double minContactSpacing = 1e-3;  ///< contacts of one link closer than this are one [m]
};

/// Called from any thread after each candidate.
using PlanProgress = std::function<void(const Grasp&)>;

struct PlanExtras
{
    PlanProgress progress = {};
    /// At rest in W beside the object. A candidate that touches one is rejected
    /// (RejectReason::Obstacle), provided that the closing engine knows them, too. What the boxes
    /// that the hand sweeps do not meet costs no query.
    std::span<const RigidBody> obstacles = {};
    /// Candidates of an earlier plan of the same hand, object, obstacles and options: they are
    /// taken over as they are, without a call of `progress`.
    std::span<const Grasp> known = {};
};

/// All candidates, best first. Order: force closures by epsilon (ties by candidate number), then
/// the other grasps, then the rejected ones by candidate number.
///
/// Candidates are begun in the order of their numbers and those begun are finished, so that a time
/// limit leaves out the last numbers alone; at least one that is not known is planned, whatever the
/// limit. What comes out of a candidate depends neither on threads nor on the limit, so a plan that
/// is continued with what it gave (`known`) ends as one that was never stopped.
/// Throws std::invalid_argument for options that make no sense, and for known candidates that are
/// there twice or are none of options.candidates.
[[nodiscard]] BULLET_CCD_API std::vector<Grasp> planGrasps(const HandModel& hand,
                                                           const GraspObject& object,
                                                           const PlannerOptions& options,
                                                           const MakeCloseHand& makeCloseHand,
                                                           const PlanExtras& extras = {});
}  // namespace bullet_ccd::grasp
