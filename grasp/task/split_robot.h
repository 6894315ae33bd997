/// A robot of one file as an arm and its hand.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/io/robot_file.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// mountHand() makes the whole of it again, with the names that it has.
struct SplitRobot
{
    RobotModel arm;      ///< all links but those of the hand
    RobotModel hand;     ///< the links below its root
    std::string flange;  ///< the link of the arm that carries the hand
    Eigen::Isometry3d X_FH = Eigen::Isometry3d::Identity();  ///< pose of the hand's root in it
};

/// The links with which hands begin: those that are named; else those of the SRDF's end effectors
/// (`<end_effector parent_link=".." group=".."/>`: the link below the parent that the group is in);
/// else they are inferred: where a chain that a joint moves divides into fingers, and what is fixed
/// between the palm and the last joint before it belongs to the hand. What divides into chains of
/// three or more joints which divide themselves is a torso and no palm.
/// Throws std::runtime_error "<file>: <what>: <remedy>" for a name that no link has, an end
/// effector that does not fit, and if none is found.
[[nodiscard]] BULLET_CCD_API std::vector<std::int32_t> findHandRoots(
    const RobotModel& robot,
    const std::optional<std::filesystem::path>& srdf,
    std::span<const std::string> named);

/// Splits a robot at the root of its hand. Where a joint moves that link, the arm gets a link
/// without shape for it, "<name>_carrier".
/// Throws std::runtime_error if a joint on one side follows one on the other.
[[nodiscard]] BULLET_CCD_API SplitRobot splitRobot(const RobotModel& robot, std::int32_t handRoot);

/// The two arms of a robot with two hands, each with its hand, without the links of the other; the
/// first is the one whose first joint is farther along y (the left one, if the robot looks along
/// x). The links that carry both remain in both.
/// Throws std::runtime_error if these have a shape, or a joint moves them: that is not supported;
/// and if one hand hangs from the other.
[[nodiscard]] BULLET_CCD_API std::array<SplitRobot, 2> splitArms(
    const RobotModel& robot, const std::array<std::int32_t, 2>& handRoots);
}  // namespace bullet_ccd::grasp
