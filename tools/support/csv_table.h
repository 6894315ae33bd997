/// CSV files whose first line names the columns, and poses in seven of their columns.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::tools
{
struct CsvRow
{
    std::size_t line = 0;  ///< in the file, from 1
    std::vector<std::string> cells;
};

struct CsvTable
{
    std::filesystem::path path;
    std::size_t line = 1;  ///< of the names
    std::vector<std::string> names;
    std::vector<CsvRow> rows;

    /// Index of the column of that name.
    [[nodiscard]] std::optional<std::size_t> find(const std::string& name) const;

    /// Throws std::runtime_error "<file>:<line>: <column>: <what>", if the cell is in a column of
    /// that index.
    [[noreturn]] void fail(const CsvRow& row, std::size_t column, const std::string& what) const;
    /// Likewise of the line that names the columns.
    [[noreturn]] void failNames(const std::string& what) const;

    /// The number in the cell. Throws as fail().
    [[nodiscard]] double number(const CsvRow& row, std::size_t column) const;
};

/// Reads all rows; empty lines are skipped, spaces around cells do not matter.
/// Throws std::runtime_error "<file>:<line>: <what>: <remedy>" if the file cannot be read, a name
/// is empty or there twice, or a row has another number of cells.
/// @param remedy  what to give instead of a file that cannot be read
[[nodiscard]] CsvTable readCsvTable(const std::filesystem::path& path, const std::string& remedy);

/// Where qw qx qy qz tx ty tz are, behind a prefix.
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
