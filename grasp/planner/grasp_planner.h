/// The planner: it samples candidates, approaches, closes, scores and ranks; or it closes at a pose
/// that the caller chooses.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/approach/approach.h"
#include "grasp/closing/closing.h"
#include "grasp/quality/wrench_space.h"

#include <functional>
#include <optional>
#include <span>

namespace bullet_ccd::grasp
{
/// What a plan is asked.
struct PlannerOptions
{
    std::int64_t candidates = 20;
    std::uint64_t seed = 1;
    int jobs = 0;            ///< threads; 0: one per core. Results do not depend on it.
    double timeLimit = 0.0;  ///< after it no candidate is begun [s]; 0: no limit
    ApproachOptions approach = {.source = ApproachSource::Mixed};
    ClosingOptions closing = {};
    /// The engine that the caller hands to planGrasps(). It is kept here for the record.
    ClosingEngine engine = ClosingEngine::Kinematic;
    int volumes = 3;  ///< number of best grasps that get the volume of their wrench space
    double friction = ContactLaw{}.friction;
    /// Edges of friction pyramids that epsilon takes for cones; 0: exact cones. Volumes and the
    /// largest mass need pyramids in any case: pyramidEdges().
    int coneEdges = 0;
    /// Of the object, for the question whether a grasp holds its weight [kg]. It changes no grasp.
    /// None: massOf() its volume.
    std::optional<double> mass{};
    /// For the same question: efforts of the independent joints in place of those of the hand
    /// [N m or N]; empty: jointEfforts().
    std::vector<double> efforts{};
    double forceClosureThreshold = 0.005;
    double minContactSpacing = 1e-3;  ///< closer contacts of one link become one [m]
    /// At a pose that the caller chooses: jaws on one motor that touch on one side go sideways, as
    /// they do in plans. Real grippers are moved by what they touch, or move it.
    bool centred = false;
};

/// Edges of the pyramids of what is not computed with exact cones: options.coneEdges, or 8.
[[nodiscard]] constexpr int pyramidEdges(const PlannerOptions& options)
{
    constexpr int kUsual = 8;
    return options.coneEdges > 0 ? options.coneEdges : kUsual;
}

/// Is called after each candidate, from any thread.
using PlanProgress = std::function<void(const Grasp&)>;

/// Optional inputs of a plan.
struct PlanExtras
{
    PlanProgress progress = {};
    /// Bodies at rest in W beside the object. An open hand whose approach ends at one is drawn back
    /// from there. A candidate that touches one while it closes, or that holds nothing farther
    /// back, is rejected (RejectReason::Obstacle), provided that the closing engine knows them,
    /// too. Obstacles that the swept boxes of the hand do not meet cost no query.
    std::span<const RigidBody> obstacles = {};
    /// Whether the hand can be brought to a pose of its root link; empty: to all. Force closures
    /// for which it says no are rejected (RejectReason::OutOfReach). Is asked from any thread, and
    /// must not depend on anything but the pose.
    std::function<bool(const Eigen::Isometry3d& X_WH)> reach = {};
    /// Candidates of an earlier plan of the same hand, object, obstacles and options. They are
    /// taken over as they are, without a call of `progress`.
    std::span<const Grasp> known = {};
    /// Is asked before each candidate, from any thread but never by two at once: true ends the plan
    /// as a time limit does.
    std::function<bool()> stop = {};
};

/// All candidates, best first: force closures by epsilon (ties by candidate number), then the other
/// grasps, then the rejected candidates by number.
///
/// With ApproachSource::Mixed, candidates go where candidates before them succeeded:
/// SourceSchedule.
///
/// Guarantee: the outcome of a candidate depends neither on the number of threads nor on the time
/// limit. So a plan that is continued from its own result (`known`) ends like one that was never
/// stopped. Candidates are begun in the order of their numbers, and every one that is begun is
/// finished, so a time limit leaves out the last numbers only. At least one candidate that is not
/// known is planned, whatever the limit.
/// Throws std::invalid_argument for bad options, and for known candidates that appear twice or are
/// not among options.candidates.
[[nodiscard]] BULLET_CCD_API std::vector<Grasp> planGrasps(const HandModel& hand,
                                                           const GraspObject& object,
                                                           const PlannerOptions& options,
                                                           const MakeCloseHand& makeCloseHand,
                                                           const PlanExtras& extras = {});

// A pose that the caller chooses, instead of sampled candidates.

/// Moves the open hand from X_WStart along `shift` (W [m], may be zero) until its first contact or
/// the end of the shift. Then closes it there once and scores what it holds. Nothing is sampled or
/// retreated, or, unless the options ask for it, centred.
///
/// The reject reasons, in the order in which they are looked for, are OverlapAtStart (by the
/// independent check), SelfOverlap, IterationLimit (then the hand was not closed, and there are no
/// joint positions), Penetration, TooFewContacts and NoForceClosure.
/// A force closure knows the largest mass that it holds (GraspQuality::largestMass) if volumes are
/// asked for.
/// @param obstacles  bodies at rest in W that end the approach as the object does, and make the
/// grasp
///                   one of RejectReason::Obstacle; the engine has to know them, too
/// @param options  only those of closing, contacts and quality are used
[[nodiscard]] BULLET_CCD_API Grasp closeAtPose(const HandModel& hand,
                                               const GraspObject& object,
                                               const Eigen::Isometry3d& X_WStart,
                                               const Eigen::Vector3d& shift,
                                               const Preshape& preshape,
                                               const PlannerOptions& options,
                                               const CloseHand& close,
                                               std::span<const RigidBody> obstacles = {});

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
                                                   const CloseHand& close,
                                                   std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::grasp
