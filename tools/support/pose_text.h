/// Numbers and poses as users write them, in files and on the command line.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::tools
{
/// A decimal number, for example -1.5 or 2e-3, with a dot in every locale and white space around.
/// Throws std::invalid_argument "'<text>' <what is wrong>: <remedy>" for anything else, and for
/// numbers that are not finite or beyond 1e15, where a double no longer resolves a tenth.
[[nodiscard]] double numberFrom(std::string_view text);

/// `count` numbers separated by commas. Throws std::invalid_argument as numberFrom().
[[nodiscard]] std::vector<double> numbersFrom(std::string_view text, std::size_t count);

/// What the numbers of a pose are called, in the order of poseFrom().
inline constexpr std::array<std::string_view, 7> kPoseNames{
    "qw", "qx", "qy", "qz", "tx", "ty", "tz"};

/// How far the length of a quaternion may be from 1: enough for numbers rounded to four digits.
inline constexpr double kQuaternionSlack = 1e-3;

/// Pose from qw, qx, qy, qz, tx, ty, tz; the quaternion is normalised. Throws std::invalid_argument
/// if its length is not 1 within kQuaternionSlack.
[[nodiscard]] Eigen::Isometry3d poseFrom(std::span<const double, 7> values);
}  // namespace bullet_ccd::tools
