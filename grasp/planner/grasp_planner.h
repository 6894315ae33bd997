/// Sample, approach, close, score, rank.
#pragma once

#include "grasp/approach/approach_sampler.h"
#include "grasp/closing/closing.h"
#include "grasp/quality/wrench_space.h"

#include <atomic>
#include <functional>

namespace bullet_ccd::grasp
{
struct PlannerOptions
{
    std::int64_t candidates = 20;
    std::uint64_t seed = 1;
    int jobs = 0;  ///< threads; 0: one a core. Results do not depend on it.
    ClosingOptions closing = {};
    /// That the caller hands to planGrasps(); kept here for the record.
    ClosingEngine engine = ClosingEngine::Kinematic;
    int volumes = 3;  ///< so many of the best grasps get the volume of their wrench space
    double friction = 0.5;
    int coneEdges = 8;
    double forceClosureThreshold = 0.005;
    double minContactSpacing = 1e-3;  ///< contacts of one link closer than this are one [m]
};

/// Called from any thread after each candidate.
using PlanProgress = std::function<void(const Grasp&)>;

/// All candidates, best first. `obstacles` rest in W beside the object; a candidate that touches
/// one is rejected (RejectReason::Obstacle), provided that the closing engine knows them, too. What
/// the boxes that the hand sweeps do not meet costs no query. Order: force closures by epsilon
/// (ties by candidate number), then the other grasps, then the rejected ones by candidate number.
[[nodiscard]] std::vector<Grasp> planGrasps(const HandModel& hand,
                                            const GraspObject& object,
                                            const PlannerOptions& options,
                                            const MakeCloseHand& makeCloseHand,
                                            const PlanProgress& progress = {},
                                            std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::grasp
