#include "tools/ccd_cli/files/query_file.h"

#include "tools/support/csv_text.h"
#include "tools/support/pose_text.h"
#include "tools/ccd_cli/files/query_columns.h"

#include <array>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

/// Reads the cells of one row; messages name the column.
class RowReader
{
public:
    RowReader(const QueryColumns& columns, const std::vector<std::string>& cells)
        : m_columns(columns), m_cells(cells)
    {
    }

    [[nodiscard]] RigidMotion motion(const BodyColumns& body) const
    {
        const Eigen::Isometry3d start = pose(body.start);
        if (m_columns.form == QueryForm::Poses)
        {
            return motionBetween(start, pose(body.end));
        }
        const std::array<double, 6> twist = numbers(body.twist);
        return {.X_W0 = start,
                .v_W = Eigen::Vector3d(twist[0], twist[1], twist[2]),
                .w_W = Eigen::Vector3d(twist[3], twist[4], twist[5])};
    }

private:
    template <typename Function>
    [[nodiscard]] auto named(std::size_t column, const Function& function) const
    {
        try
        {
            return function();
        }
        catch (const std::invalid_argument& error)
        {
            throw std::invalid_argument(m_columns.names[column] + ": " + error.what());
        }
    }

    template <std::size_t n>
    [[nodiscard]] std::array<double, n> numbers(const std::array<std::size_t, n>& columns) const
    {
        std::array<double, n> values{};
        for (std::size_t k = 0; k < n; ++k)
        {
            values[k] = named(columns[k], [&] { return numberFrom(m_cells[columns[k]]); });
        }
        return values;
    }

    [[nodiscard]] Eigen::Isometry3d pose(const std::array<std::size_t, 7>& columns) const
    {
        const std::array<double, 7> values = numbers(columns);
        return named(columns[0], [&] { return poseFrom(values); });
    }

    const QueryColumns& m_columns;
    const std::vector<std::string>& m_cells;
};

/// Appends the query of one line, or what is wrong with it.
void addRow(QueryFile& file,
            const QueryColumns& columns,
            std::string_view text,
            const fs::path& path,
            std::size_t line)
{
    std::string id;
    try
    {
        const std::optional<std::vector<std::string>> cells = csvCells(text);
        if (!cells)
        {
            throw std::invalid_argument(
                "a quote is not closed, or text follows it: write \"id\" or no quotes");
        }
        id = columns.id < cells->size() ? (*cells)[columns.id] : "";
        if (cells->size() != columns.names.size())
        {
            throw std::invalid_argument(
                fmt::format("{} cells instead of {}: write one for each column of the first line",
                            cells->size(),
                            columns.names.size()));
        }
        if (id.empty())
        {
            throw std::invalid_argument("id: no value: give the row a name");
        }
        const RowReader row(columns, *cells);
        file.queries.push_back({.id = id,
                                .motionA = row.motion(columns.a),
                                .motionB = row.motion(columns.b),
                                .line = line});
    }
    catch (const std::invalid_argument& error)
    {
        file.badRows.push_back(
            {.id = id,
             .line = line,
             .message = fmt::format("{}:{}: {}", path.string(), line, error.what())});
    }
}
}  // namespace

QueryFile readQueryFile(const fs::path& path)
{
    const std::string content = contentOfFile(path, "give a CSV file of queries");
    QueryFile file;
    std::optional<QueryColumns> columns;
    for (const NumberedLine& line : linesOf(content))
    {
        if (!columns)
        {
            columns = queryColumns(line.text, path, line.line);
            file.form = columns->form;
        }
        else
        {
            addRow(file, *columns, line.text, path, line.line);
        }
    }
    if (!columns)
    {
        (void)queryColumns("", path, 1);  // says what is missing
    }
    return file;
}
}  // namespace bullet_ccd::tools
