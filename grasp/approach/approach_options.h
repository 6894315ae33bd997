/// Options of sampled approaches.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Core>

#include <cstdint>
#include <numbers>
#include <optional>

namespace bullet_ccd::grasp
{
/// What approaches are sampled from.
enum class ApproachSource : std::uint8_t
{
    Sphere,   ///< directions around the object, towards its centre of mass or near it
    Surface,  ///< points of its surface, against the normal there
    Boxes,    ///< faces of the box along its principal axes
};

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
