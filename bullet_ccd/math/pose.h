/// What a pose must be before a query rests its certificate on it; rotations between directions.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Geometry>

#include <string>

namespace bullet_ccd
{
/// True if X is a rotation and a translation: all numbers finite, the axes of unit length and at
/// right angles up to 1e-4, not mirrored. So much may rotations in single precision drift along a
/// chain; distances err by as much as the axes do.
[[nodiscard]] bool isPose(const Eigen::Isometry3d& X);

/// Throws std::invalid_argument: what isPose() found wrong with X, and the remedy.
[[noreturn]] void failPose(const std::string& where, const Eigen::Isometry3d& X);

/// Rotation by the least angle that turns the direction of `from` into that of `to`; for opposite
/// directions, by pi about an axis across them. Neither may be zero. (Eigen's FromTwoVectors() is the
/// same, but a file that calls it takes five seconds longer to compile.)
[[nodiscard]] BULLET_CCD_API Eigen::Quaterniond rotationBetween(const Eigen::Vector3d& from,
                                                                const Eigen::Vector3d& to);
}  // namespace bullet_ccd
