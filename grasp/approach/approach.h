/// The approach: the hand moves without closing until its first contact, along a line, along a
/// path, or as a planner samples it.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/hand/hand_model.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// First contact of any link with the environment while the hand moves along `shift` (W [m]) from
/// X_WH, with its joints at rest. A hit leaves about half the tolerance as gap, so that closing can
/// go on from there; with a tolerance coarser than the default, any part of it.
///
/// Guarantee: as that of articulatedToi().
/// @param X_WH      pose of the root link
/// @param positions one entry per link [rad or m]
/// @param tolerance [m]
/// Throws std::invalid_argument as articulatedToi() does.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
approachUntilContact(const HandModel& hand,
                     const Environment& environment,
                     const Eigen::Isometry3d& X_WH,
                     const std::vector<double>& positions,
                     const Eigen::Vector3d& shift,
                     double tolerance,
                     ToiWorkspace& work);

/// Where the motion of a hand along a path ended.
struct PathApproach
{
    /// Of the last leg that was begun. It is Separated or TouchingLeaving at the end of the path.
    ToiStatus status = ToiStatus::Separated;
    std::size_t leg = 0;  ///< the last leg that was begun, from 0
    double time = 1.0;    ///< certified on that leg, in [0, 1]
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< pose of the root link there
    double length = 0.0;                                     ///< way of the root link's origin [m]
    std::vector<LinkContact> contacts = {};                  ///< as of articulatedToi()
};

/// The same along a path of poses of the root link. On each leg its origin moves on a straight
/// line, and the link turns about it by the shortest arc, both at constant speed (motionBetween()).
/// Every leg is one query, and the first contact ends the motion. On a path of one pose nothing
/// moves.
/// Throws std::invalid_argument for a path without a pose, and as articulatedToi() does.
[[nodiscard]] BULLET_CCD_API PathApproach
approachUntilContact(const HandModel& hand,
                     const Environment& environment,
                     std::span<const Eigen::Isometry3d> path,
                     const std::vector<double>& positions,
                     double tolerance,
                     ToiWorkspace& work);

// Where sampled approaches come from.

/// What approaches are sampled from.
enum class ApproachSource : std::uint8_t
{
    Sphere,   ///< directions around the object, towards its centre of mass or near it
    Surface,  ///< points of its surface, against the normal there
    Boxes,    ///< faces of the box along its principal axes
    Pinch,    ///< across what is thin: rims, handles, edges
    Mixed,    ///< all of these; the planner spends candidates where they succeed
};
/// What Mixed is made of.
inline constexpr std::array kMixedSources{
    ApproachSource::Sphere, ApproachSource::Surface, ApproachSource::Boxes, ApproachSource::Pinch};

[[nodiscard]] BULLET_CCD_API const char* toString(ApproachSource source);

/// Range of the angle of roll about the direction of approach [rad].
struct RollLimits
{
    double from = 0.0;
    double to = 0.0;
};

struct ApproachOptions
{
    ApproachSource source = ApproachSource::Sphere;
    bool tableTop = false;                          ///< no approach from below: maxTilt applies
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< in the object's frame, of any length
    /// Largest angle between the direction of approach and -up for tableTop, in [0, pi] [rad].
    double maxTilt = 0.5 * std::numbers::pi;
    double standoff = 0.0;  ///< added to the distance from which the hand starts [m]
    double reach = 0.0;     ///< longest travel of the hand [m]; 0: past the object
    /// Range of the roll of the grasp frame's x axis. The roll is 0 where the axis runs along up x
    /// direction and is level. For directions within kSteep of up or -up it is measured from the
    /// object's x axis instead, or from its y axis if x is within 2 kSteep of up or -up. Without a
    /// range the roll is chosen to fit the object.
    std::optional<RollLimits> roll{};
};

/// Largest angle between the direction of approach and the normal at its surface point [rad].
inline constexpr double kLargestTurn = 0.2;
/// Angle from up or down [rad] within which one level axis cannot be told from another.
inline constexpr double kSteep = 0.3;

/// Throws std::invalid_argument that names the bad option and says what it must be.
BULLET_CCD_API void checkApproachOptions(const ApproachOptions& options);
}  // namespace bullet_ccd::grasp
