#include "tools/support/csv_table.h"

#include "tools/support/csv_text.h"
#include "tools/support/pose_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
[[noreturn]] void failAt(const CsvTable& table, std::size_t line, const std::string& what)
{
    throw std::runtime_error(fmt::format("{}:{}: {}", table.path.string(), line, what));
}

std::vector<std::string> cellsOf(const CsvTable& table, const NumberedLine& line)
{
    std::optional<std::vector<std::string>> cells = csvCells(line.text);
    if (!cells)
    {
        failAt(table,
               line.line,
               "a quote is not closed, or text follows it: write \"text\" or no quotes");
    }
    return *std::move(cells);
}

void requireGoodNames(const CsvTable& table)
{
    for (std::size_t k = 0; k < table.names.size(); ++k)
    {
        if (table.names[k].empty())
        {
            table.failNames(fmt::format("column {} has no name: name it or remove it", k + 1));
        }
        if (table.find(table.names[k]) != k)
        {
            table.failNames(fmt::format("column {} is there twice: remove one", table.names[k]));
        }
    }
}
}  // namespace

std::optional<std::size_t> CsvTable::find(const std::string& name) const
{
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? std::nullopt
                                : std::optional(static_cast<std::size_t>(found - names.begin()));
}

void CsvTable::fail(const CsvRow& row, std::size_t column, const std::string& what) const
{
    failAt(*this, row.line, names[column] + ": " + what);
}

void CsvTable::failNames(const std::string& what) const
{
    failAt(*this, line, what);
}

double CsvTable::number(const CsvRow& row, std::size_t column) const
{
    try
    {
        return numberFrom(row.cells[column]);
    }
    catch (const std::invalid_argument& error)
    {
        fail(row, column, error.what());
    }
}

CsvTable readCsvTable(const std::filesystem::path& path, const std::string& remedy)
{
    const std::string content = contentOfFile(path, remedy);
    CsvTable table;
    table.path = path;
    for (const NumberedLine& line : linesOf(content))
    {
        std::vector<std::string> cells = cellsOf(table, line);
        if (table.names.empty())
        {
            table.line = line.line;
            table.names = std::move(cells);
            requireGoodNames(table);
            continue;
        }
        if (cells.size() != table.names.size())
        {
            failAt(
                table,
                line.line,
                fmt::format("{} cells instead of {}: write one for each column of the first line",
                            cells.size(),
                            table.names.size()));
        }
        table.rows.push_back({.line = line.line, .cells = std::move(cells)});
    }
    if (table.rows.empty())
    {
        failAt(table,
               table.line,
               "no row below the names of the columns: write the names, and a row of numbers");
    }
    return table;
}

bool isPoseColumn(std::string_view name, std::string_view prefix)
{
    return name.substr(0, prefix.size()) == prefix &&
           std::find(kPoseNames.begin(),
                     kPoseNames.end(),
                     name.substr(std::min(prefix.size(), name.size()))) != kPoseNames.end();
}

std::optional<PoseColumns> poseColumns(const CsvTable& table, const std::string& prefix)
{
    PoseColumns columns{};
    std::string missing;
    bool hasSome = false;
    for (std::size_t k = 0; k < kPoseNames.size(); ++k)
    {
        const std::string name = fmt::format("{}{}", prefix, kPoseNames[k]);
        const std::optional<std::size_t> column = table.find(name);
        hasSome = hasSome || column.has_value();
        columns[k] = column.value_or(0);
        if (!column)
        {
            missing += (missing.empty() ? "" : ", ") + name;
        }
    }
    if (hasSome && !missing.empty())
    {
        table.failNames(
            fmt::format("a pose is given, but not {}: give all seven columns or none", missing));
    }
    return hasSome ? std::optional(columns) : std::nullopt;
}

Eigen::Isometry3d poseOf(const CsvTable& table, const CsvRow& row, const PoseColumns& columns)
{
    std::array<double, 7> values{};
    for (std::size_t k = 0; k < values.size(); ++k)
    {
        values[k] = table.number(row, columns[k]);
    }
    try
    {
        return poseFrom(values);
    }
    catch (const std::invalid_argument& error)
    {
        table.fail(row, columns[0], error.what());
    }
}
}  // namespace bullet_ccd::tools
