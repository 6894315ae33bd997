/// CSV files of joint positions: the first line names the joints, every other line is one
/// configuration of the robot.
///
/// Positions are rad or m. Columns of other names: `id` (any text), `time` [s] (read only where it
/// is asked for), and, all seven or none, base_qw base_qx base_qy base_qz base_tx base_ty base_tz,
/// the pose of the root. Joints that follow another one (mimic) may have columns, as joint states
/// do; what they say is replaced by what the robot says. Joints without a column rest at 0, or at
/// the limit next to it.
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct Configuration
{
    std::string id;                 ///< number of the row, from 0, if the file has none
    std::vector<double> positions;  ///< one entry a link, mimics included
    std::optional<Eigen::Isometry3d> base;
    double time = 0.0;  ///< [s], the number of the row if the file has none
};

struct JointFile
{
    std::vector<Configuration> rows;  ///< one at least
    std::vector<std::string> names;   ///< of the joints that have columns
    std::vector<std::string> notes;   ///< what was assumed or looks wrong, one line each
};

enum class TimeColumn
{
    NotUsed,
    Increasing,  ///< read, and required to increase from row to row
};

/// Throws std::runtime_error "<file>:<line>: <column>: <what, value>: <remedy>": columns that name
/// no joint that moves, cells that are no finite numbers, quaternions that are none, times that do
/// not increase.
[[nodiscard]] JointFile readJointFile(const std::filesystem::path& path,
                                      const KinematicTree& tree,
                                      TimeColumn times = TimeColumn::NotUsed);

/// The names of all joints that a file may give, for messages: those that move and follow no other.
[[nodiscard]] std::string drivenNames(const KinematicTree& tree);
}  // namespace bullet_ccd::tools
