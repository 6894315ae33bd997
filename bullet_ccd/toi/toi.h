/// What all time-of-impact queries share: options, statuses, results.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// What the answer of a time-of-impact query promises.
enum class ToiStatus : std::uint8_t
{
    Separated,       ///< no contact in [0, 1]; time is 1
    Hit,             ///< no contact in [0, time); 0 < distance <= tolerance at `time`
    Overlapping,     ///< surfaces intersect at t = 0; time is 0
    IterationLimit,  ///< gave up; no contact in [0, time)
};

struct ToiOptions
{
    /// Two surfaces count as in contact at this distance [m]; > 0. Bodies that are already closer
    /// at t = 0 must close in to three quarters of that distance before they count as in contact
    /// again, so that a query restarted from a contact can leave it or slide.
    double tolerance = 1e-5;
    std::int64_t maxIterations = 10'000'000;  ///< node and triangle pairs examined
};

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
    double gap = 0.0;   ///< for Hit: distance at `time` [m]
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();  ///< witnesses at `time`, in W [m]
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from A to B, in W
    ToiCounters counters;
};
}  // namespace bullet_ccd
