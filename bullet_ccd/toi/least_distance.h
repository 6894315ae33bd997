/// The smallest distance of moving bodies over a whole motion, certified: what a planner that keeps
/// clearance asks, beside the time of impact.
///
/// A local search follows a pair of triangles down to where it is nearest; that distance is
/// reached, so the truth is not larger. A time-of-impact query then asks for a contact at a minimum
/// separation that is smaller by the tolerance. Either there is none, which certifies the answer,
/// or the contact is the start of the next local search. A few queries are enough, because each of
/// them finds another dip that is deeper by at least three quarters of the tolerance.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <Eigen/Core>

#include <cstdint>
#include <limits>
#include <span>

namespace bullet_ccd
{
struct LeastDistanceOptions
{
    /// How far below the truth the answer may be [m]; > 0. A thousandth of it costs a few more
    /// steps only where distances change; where they hardly do, steps grow with its root.
    double tolerance = kDefaultTolerance;
    /// Larger distances need not be known [m]; > 0. A motion that keeps this clearance costs one
    /// query.
    double enough = std::numeric_limits<double>::infinity();
    std::int64_t maxIterations = ToiOptions{}.maxIterations;  ///< of one time-of-impact query
    int maxQueries = 100;                                     ///< time-of-impact queries
    StopCondition stop{};  ///< deadline and cancellation; the status is then Stopped
};

struct LeastDistanceResult
{
    /// Separated: complete. Overlapping: complete, and the surfaces intersect at `time`.
    /// IterationLimit or Stopped: the query gave up; `distance` is what is certified nevertheless,
    /// and `found` what was found by then.
    ToiStatus status = ToiStatus::Separated;
    /// Certified: no tested pair comes closer at any time [m]. If the query is complete, this is at
    /// most the tolerance below the true least distance or `enough`, whichever is smaller, and
    /// never above the truth.
    double distance = 0.0;
    /// The distance of the named pair at `time` [m]: the true least distance is between `distance`
    /// and this. `enough`, without a pair, if all distances are larger.
    double found = std::numeric_limits<double>::infinity();
    double time = 0.0;          ///< at which `found` is reached
    std::int32_t pair = kNone;  ///< index into the pairs
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();  ///< closest points at `time`, in W [m]
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    /// Unit, from A to B, in W, at `time`: the direction in which the distance grows. Zero if the
    /// surfaces intersect.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    ToiCounters counters;
    int queries = 0;  ///< time-of-impact queries
};

/// The smallest distance of the pairs of bodies over t in [0, 1].
///
/// Guarantee: `distance` is never above the truth; see LeastDistanceResult.
/// @param work scratch, reusable; one per thread
/// Throws std::invalid_argument as firstContact() does, for a tolerance or `enough` that is not
/// positive, and for no pairs with an infinite `enough`.
[[nodiscard]] BULLET_CCD_API LeastDistanceResult leastDistance(std::span<const MovingBody> bodies,
                                                               std::span<const BodyPair> pairs,
                                                               const LeastDistanceOptions& options,
                                                               ToiWorkspace& work);

/// The same of two rigid bodies.
[[nodiscard]] BULLET_CCD_API LeastDistanceResult leastDistance(const RigidBody& bodyA,
                                                               const RigidBody& bodyB,
                                                               const LeastDistanceOptions& options,
                                                               ToiWorkspace& work);

/// Of an articulated body; LeastDistanceResult::pair has no meaning there, A is the link.
struct ArticulatedLeastDistance : LeastDistanceResult
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;   ///< index into the obstacles, or kNone for two links
    std::int32_t otherLink = kNone;  ///< for two links
};

/// The same of a moving articulated body and its surroundings, and of its links that are paired. As
/// with articulatedToi(), pairs without relative motion are left out.
[[nodiscard]] BULLET_CCD_API ArticulatedLeastDistance
leastDistance(const ArticulatedBody& body,
              const Environment& environment,
              const LeastDistanceOptions& options,
              ToiWorkspace& work);

/// The same for obstacles of a single query; the boxes over them are made here.
[[nodiscard]] BULLET_CCD_API ArticulatedLeastDistance
leastDistance(const ArticulatedBody& body,
              std::span<const RigidBody> obstacles,
              const LeastDistanceOptions& options,
              ToiWorkspace& work);
}  // namespace bullet_ccd
