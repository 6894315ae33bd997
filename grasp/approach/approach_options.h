/// What a user may ask of sampled approaches.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Core>

#include <cstdint>
#include <numbers>
#include <optional>

namespace bullet_ccd::grasp
{
/// What the approaches are spread over.
enum class ApproachSource : std::uint8_t
{
    Sphere,   ///< directions around the object, towards about its centre of mass
    Surface,  ///< points of its surface, against the normal there
    Boxes,    ///< faces of the box along its principal axes
};

[[nodiscard]] BULLET_CCD_API const char* toString(ApproachSource source);

/// Angles of roll, from `from` to `to` about the direction of approach [rad].
struct RollLimits
{
    double from = 0.0;
    double to = 0.0;
};

struct ApproachOptions
{
    ApproachSource source = ApproachSource::Sphere;
    bool tableTop = false;                          ///< nothing comes from below: maxTilt holds
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< in the object's frame, of any length
    /// Largest angle between the direction of approach and -up for tableTop, in [0, pi] [rad].
    double maxTilt = 0.5 * std::numbers::pi;
    double standoff = 0.0;  ///< added to the distance from which the hand starts [m]
    double reach = 0.0;     ///< longest travel of the hand [m]; 0: until it is past the object
    /// Roll of the grasp frame's x axis: 0 where it runs along up x direction, so lies level. For
    /// directions within kSteep of up or -up it is measured from the object's x axis instead (from
    /// y where x is within 2 kSteep of up or -up). None: as it fits the object.
    std::optional<RollLimits> roll{};
};

/// Largest angle between the direction of approach and the normal at its surface point [rad].
inline constexpr double kLargestTurn = 0.2;
/// From up or down, at which there is no telling a level axis from another [rad].
inline constexpr double kSteep = 0.3;

/// Throws std::invalid_argument that says which option cannot be and what it must be.
BULLET_CCD_API void checkApproachOptions(const ApproachOptions& options);
}  // namespace bullet_ccd::grasp
