#include "benchmarks/support/table.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
/// What is before the separator; `text` is left with what is behind it.
std::string_view cut(std::string_view& text, char separator)
{
    const std::size_t at = text.find(separator);
    const std::string_view before = text.substr(0, at);
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + 1);
    return before;
}

/// @param format of fmt, without its braces
template <typename Value>
std::string formatted(const std::string& format, const Value& value)
{
    return fmt::format(fmt::runtime("{:" + format + "}"), value);
}
}  // namespace

Table::Table(std::string_view columns)
{
    while (!columns.empty())
    {
        std::string_view column = cut(columns, '|');
        std::string_view names = cut(column, ':');
        const std::string head(cut(names, '='));
        const std::size_t width = std::min(column.find_first_not_of("<>0123456789"), column.size());
        m_columns.push_back({.head = head,
                             .key = names.empty() ? head : std::string(names),
                             .place = std::string(column.substr(0, width)),
                             .number = std::string(column.substr(width))});
    }
    printLine(heads());
}

std::vector<std::string> Table::heads() const
{
    std::vector<std::string> heads;
    for (const Column& column : m_columns)
    {
        heads.push_back(column.head);
    }
    return heads;
}

std::vector<std::string> Table::cells(const nlohmann::json& row) const
{
    std::vector<std::string> cells;
    for (const Column& column : m_columns)
    {
        const auto found = row.find(column.key);
        if (found == row.end() || found->is_null())
        {
            cells.emplace_back("-");
        }
        else if (found->is_string())
        {
            cells.push_back(found->get<std::string>());
        }
        else
        {
            cells.push_back(column.number.empty() ? std::to_string(found->get<std::int64_t>())
                                                  : formatted(column.number, found->get<double>()));
        }
    }
    return cells;
}

void Table::printLine(const std::vector<std::string>& cells) const
{
    std::string line;
    for (std::size_t k = 0; k < cells.size(); ++k)
    {
        line += formatted(m_columns[k].place, cells[k]) + ' ';
    }
    line.erase(line.find_last_not_of(' ') + 1);
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

void Table::print(const nlohmann::json& row) const
{
    printLine(cells(row));
}
}  // namespace bullet_ccd::benchmarks
