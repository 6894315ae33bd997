/// Options, statuses, results and scratch memory that all time-of-impact queries share.
/// docs/glossary.md defines tolerance, gap and minimum separation.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace bullet_ccd
{
/// What the answer of a time-of-impact query promises. Here d(t) is the distance of the surfaces, s
/// is the minimum separation, and e is the tolerance.
enum class ToiStatus : std::uint8_t
{
    Separated,         ///< d > s in all of [0, 1]; time is 1, gap a certified lower bound of d
    Hit,               ///< d > s in [0, time]; d <= s + e at `time`
    Overlapping,       ///< d <= s at t = 0 (surfaces intersect, if s = 0); time is 0
    TouchingLeaving,   ///< s < d <= s + e at t = 0, and d does not shrink to s: like Separated
    TouchingPressing,  ///< s < d <= s + e at t = 0, approaching, and d shrinks to s: like Hit
    IterationLimit,    ///< the query gave up; d > s in [0, time]
    Stopped,           ///< the deadline passed, or the query was cancelled; d > s in [0, time]
};

/// True for the outcomes at which the bodies must not move on: `time` is the last certified time.
[[nodiscard]] constexpr bool isContact(ToiStatus status)
{
    return status == ToiStatus::Hit || status == ToiStatus::Overlapping ||
           status == ToiStatus::TouchingPressing;
}

/// True for the outcomes that leave open what happens after `time`.
[[nodiscard]] constexpr bool gaveUp(ToiStatus status)
{
    return status == ToiStatus::IterationLimit || status == ToiStatus::Stopped;
}

/// How a query searches space and time. All strategies give the same guarantees.
enum class ToiStrategy : std::uint8_t
{
    BestFirst,  ///< one heap of node pairs, each with its own time; the earliest is looked at next
    Interval,   ///< depth first: is a pair farther apart than it can move until the end of the
                ///< interval? Else open it or halve the interval, left half first
    C2A,  ///< controlled conservative advancement: one step for the whole body at a time, from
          ///< a traversal that goes deeper as contact comes near
};

/// The default tolerance of all queries and of closing a hand [m]. The worlds of Bullet take ten
/// times as much, because Bullet may compute in single precision.
inline constexpr double kDefaultTolerance = 2e-5;

/// What a time-of-impact query is asked.
struct ToiOptions
{
    /// Surfaces count as in contact at the minimum separation plus this distance [m]; > 0. Bodies
    /// that are already closer at t = 0 must close in to three quarters of that distance before
    /// they count as in contact again, so that a query restarted from a contact can leave it or
    /// slide.
    double tolerance = kDefaultTolerance;
    /// Clearance that must be kept [m]; >= 0. The query stops before the distance falls to it.
    double minimumSeparation = 0.0;
    /// The part of the tolerance that steps leave as gap, in (0, 1/2]. With a small part the
    /// reported time is as late as possible. With 1/2 a query that goes on from there has room.
    double aim = 1.0 / 4096.0;
    /// The tolerance is the accuracy of the answer: any gap within it ends the query, which looks
    /// at no more of the meshes than that takes. The reported time is earlier than otherwise by
    /// what it takes to close that gap. `aim` has no part in this.
    bool anyWithin = false;
    ToiStrategy strategy = ToiStrategy::BestFirst;
    std::int64_t maxIterations = 20'000'000;  ///< node and triangle pairs examined
    StopCondition stop{};  ///< deadline and cancellation; the status is then Stopped
};

/// What a query cost.
struct ToiCounters
{
    std::int64_t nodePairs = 0;
    std::int64_t trianglePairs = 0;
    std::int64_t states = 0;  ///< distinct (pair of bodies, time) at which poses were computed
};

/// First contact of two bodies.
struct ToiResult
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// Distance of the named triangles at `time` [m]. No other triangles are much closer, because
    /// the time is certified (see ToiOptions::aim). For Separated it is a lower bound of the
    /// distance over the whole motion.
    double gap = 0.0;
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();  ///< witnesses at `time`, in W [m]
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from A to B, in W
    ToiCounters counters;
};

/// Scratch memory of queries. It is reusable; use one per thread.
class BULLET_CCD_API ToiWorkspace
{
public:
    ToiWorkspace();
    ~ToiWorkspace();
    ToiWorkspace(ToiWorkspace&&) noexcept;
    ToiWorkspace& operator=(ToiWorkspace&&) noexcept;

    struct Scratch;
    [[nodiscard]] Scratch& scratch() { return *m_scratch; }

private:
    std::unique_ptr<Scratch> m_scratch;
};
}  // namespace bullet_ccd
