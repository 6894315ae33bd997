/// Poses in tables: seven columns qw qx qy qz tx ty tz with a prefix.
#pragma once

#include "tools/ccd_cli/csv_table.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace bullet_ccd::tools
{
using PoseColumns = std::array<std::size_t, 7>;

/// True if the name is the prefix and one of the seven.
[[nodiscard]] bool isPoseColumn(std::string_view name, std::string_view prefix);

/// Where the pose is; nullopt if the table has none of the columns. Throws std::runtime_error if it
/// has only some.
[[nodiscard]] std::optional<PoseColumns> poseColumns(const CsvTable& table,
                                                     const std::string& prefix);

/// Throws std::runtime_error as CsvTable::fail() for what is no pose.
[[nodiscard]] Eigen::Isometry3d poseOf(const CsvTable& table,
                                       const CsvRow& row,
                                       const PoseColumns& columns);
}  // namespace bullet_ccd::tools
