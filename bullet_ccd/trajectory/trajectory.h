/// Whole trajectories of a robot in one query: the first contact, or the certificate that there is
/// none, and the least distance.
///
/// A trajectory is made of pieces, each of which is a JointMotion. The pieces are linear, cubic or
/// quintic between waypoints, or those of a B-spline. Other polynomials of at most fifth degree can
/// be written into the segments directly.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/least_distance.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Segment k runs over [times[k], times[k + 1]]; its motion is that over t in [0, 1].
struct Trajectory
{
    std::vector<double> times;  ///< [s], strictly increasing, one more than segments
    std::vector<JointMotion> segments;
};

/// Where the joints are at one time. Entries of joints that follow others (mimic) are not read.
struct Waypoint
{
    double time = 0.0;                    ///< [s]
    std::vector<double> positions;        ///< one entry per link [rad or m]
    std::vector<double> velocities{};     ///< [rad/s or m/s], one entry per link, or empty
    std::vector<double> accelerations{};  ///< [rad/s^2 or m/s^2], one entry per link, or empty
};

/// The trajectory through all waypoints. As the controllers of ROS do, a segment is the quintic
/// through both of its ends if both have velocities and accelerations, the cubic (Hermite) if both
/// have velocities, and else linear. The root and spherical joints rest.
///
/// @param X_WR pose of the root
/// Throws std::invalid_argument for fewer than two waypoints, times that do not increase, sizes
/// that do not fit the tree, and numbers that are not finite; the message names the waypoint.
[[nodiscard]] BULLET_CCD_API Trajectory trajectoryThrough(const KinematicTree& tree,
                                                          const Eigen::Isometry3d& X_WR,
                                                          std::span<const Waypoint> waypoints);

/// A B-spline in joint space.
struct JointSpline
{
    int degree = 3;             ///< 1 to 5
    std::vector<double> knots;  ///< [s], not decreasing, degree + 1 more than control points
    /// Each with one entry per link [rad or m].
    std::vector<std::vector<double>> controlPoints;
};

/// The spline over its domain [knots[degree], knots[number of control points]], a segment for each
/// interval between different knots. The root and spherical joints rest.
///
/// @param X_WR pose of the root
/// Throws std::invalid_argument for degrees, knots and control points that do not make a spline,
/// and for knots inside that are there more often than the degree says: the spline may jump there.
[[nodiscard]] BULLET_CCD_API Trajectory splineTrajectory(const KinematicTree& tree,
                                                         const Eigen::Isometry3d& X_WR,
                                                         const JointSpline& spline);

/// Positions of the joints, one entry per link [rad or m]; before the start and after the end those
/// of the start and the end.
[[nodiscard]] BULLET_CCD_API std::vector<double> positionsAt(const Trajectory& trajectory,
                                                             double time);

/// Throws std::invalid_argument unless the times increase and fit the segments, and each segment
/// begins with the joints where the one before ends, to 1e-8. Of the root and of spherical joints
/// this is not checked.
BULLET_CCD_API void checkTrajectory(const Trajectory& trajectory);

/// First contact of an articulated body on a trajectory.
struct TrajectoryToiResult
{
    /// Separated, Hit, Overlapping (at the start of `segment`), IterationLimit or Stopped.
    ToiStatus status = ToiStatus::Separated;
    double time = 0.0;             ///< [s], certified: no contact before it
    std::int32_t segment = kNone;  ///< in which the query ended; kNone if the trajectory is free
    /// As ArticulatedToiResult::contacts; LinkContact::time is the part of the segment, in [0, 1].
    std::vector<LinkContact> contacts;
    ArticulatedCounters counters;  ///< of all segments up to that one
};

/// First time at which a link comes within the tolerance of an obstacle or of a link that it is
/// paired with, on the whole trajectory.
///
/// Guarantee: no contact of any tested pair before `time`; for Separated all distances stay above
/// the minimum separation, as articulatedToi() promises segment by segment. A pair is not tested in
/// segments without relative motion of the two.
///
/// The earliest segment with a contact gives the answer, and segments that are later than one with
/// a contact are not begun. The answer has the same bits for any number of threads.
///
/// @param body        its motion is not used
/// @param environment at rest
/// @param work        scratch, reusable; one thread for each
/// Throws std::invalid_argument as articulatedToi() does, for trajectories as checkTrajectory()
/// does, for an environment that moves, and without scratch.
[[nodiscard]] BULLET_CCD_API TrajectoryToiResult trajectoryToi(const ArticulatedBody& body,
                                                               const Environment& environment,
                                                               const Trajectory& trajectory,
                                                               const ArticulatedToiOptions& options,
                                                               std::span<ToiWorkspace> work);

/// The smallest distance on a trajectory. LeastDistanceResult::time is the part of the segment.
struct TrajectoryLeastDistance : ArticulatedLeastDistance
{
    std::int32_t segment = kNone;  ///< in which `found` is reached; kNone if `enough` is kept
    double seconds = 0.0;          ///< [s], the time of the trajectory at which it is
};

/// The same as leastDistance() of an articulated body over the whole trajectory.
///
/// Guarantee: `distance` is never above the truth; see LeastDistanceResult. `found` stays infinite
/// if no pair ever moves relative to each other. The answer has the same bits for any number of
/// threads.
///
/// @param body      its motion is not used
/// @param obstacles at rest
/// @param work      scratch, reusable; one thread for each
/// Throws std::invalid_argument as leastDistance() and trajectoryToi() do.
[[nodiscard]] BULLET_CCD_API TrajectoryLeastDistance
leastDistance(const ArticulatedBody& body,
              std::span<const RigidBody> obstacles,
              const Trajectory& trajectory,
              const LeastDistanceOptions& options,
              std::span<ToiWorkspace> work);
}  // namespace bullet_ccd
