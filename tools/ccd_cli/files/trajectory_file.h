/// Files of trajectories: CSV of joint positions, and the YAML form of ROS's
/// trajectory_msgs/JointTrajectory.
#pragma once

#include "bullet_ccd/trajectory/trajectory.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct TrajectoryFile
{
    Trajectory trajectory;
    std::vector<std::string> notes;  ///< what was assumed or looks wrong, one line each
};

/// A file that ends in .csv is one of joint positions (see joint_file.h), a row a waypoint, with
/// the column `time` [s] or a second from row to row; the motion between is linear.
///
/// One that ends in .yaml or .yml has the keys of trajectory_msgs/JointTrajectory (or such a
/// message below the key joint_trajectory): header (not used), joint_names, and points with
/// positions, velocities, accelerations, effort (not used) and time_from_start, which is a map of
/// sec and nanosec or a number of seconds. Between points with velocities the motion is cubic, with
/// accelerations too quintic, else linear.
///
/// @param X_WR pose of the root
/// Throws std::runtime_error "<file>:<line>: <what, value>: <remedy>": names of no joints that
/// move, numbers that are none, times that do not increase, fewer than two waypoints, another kind
/// of file.
[[nodiscard]] TrajectoryFile readTrajectoryFile(const std::filesystem::path& path,
                                                const KinematicTree& tree,
                                                const Eigen::Isometry3d& X_WR);

/// The files themselves, and of folders all files in them that end in .csv, .yaml or .yml, by name.
/// Throws std::runtime_error for folders without any.
[[nodiscard]] std::vector<std::filesystem::path> trajectoryFilesOf(
    const std::vector<std::string>& paths);
}  // namespace bullet_ccd::tools
