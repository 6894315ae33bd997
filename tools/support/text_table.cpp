#include "tools/support/text_table.h"

#include "tools/support/csv_text.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <iterator>

namespace bullet_ccd::tools
{
namespace
{
bool isNumber(const std::string& text)
{
    return text.empty() || text == "-" || std::isdigit(static_cast<unsigned char>(text[0])) != 0 ||
           (text[0] == '-' && text.size() > 1);
}

bool isNumeric(const TextTable& table, std::size_t column)
{
    return std::all_of(table.rows.begin(),
                       table.rows.end(),
                       [&](const auto& row) { return isNumber(row[column]); });
}

std::string line(const std::vector<std::string>& cells,
                 const std::vector<std::size_t>& widths,
                 const std::vector<bool>& toTheRight)
{
    std::string text;
    for (std::size_t k = 0; k < cells.size(); ++k)
    {
        text += toTheRight[k] ? fmt::format("{:>{}}", cells[k], widths[k])
                              : fmt::format("{:<{}}", cells[k], widths[k]);
        text += "  ";
    }
    text.erase(text.find_last_not_of(' ') + 1);
    return text + '\n';
}
}  // namespace

std::string joined(const std::vector<std::string>& texts, const std::string& separator)
{
    std::string text;
    for (const std::string& part : texts)
    {
        text += (&part == texts.data() ? "" : separator) + part;
    }
    return text;
}

std::string alignedText(const TextTable& table)
{
    std::vector<std::size_t> widths;
    std::vector<bool> toTheRight;
    for (std::size_t k = 0; k < table.header.size(); ++k)
    {
        std::size_t width = table.header[k].size();
        for (const auto& row : table.rows)
        {
            width = std::max(width, row[k].size());
        }
        widths.push_back(width);
        toTheRight.push_back(isNumeric(table, k));
    }
    std::string text = line(table.header, widths, toTheRight);
    for (const auto& row : table.rows)
    {
        text += line(row, widths, toTheRight);
    }
    return text;
}

std::string markdownText(const TextTable& table)
{
    std::string text = fmt::format("| {} |\n|", joined(table.header, " | "));
    for (std::size_t k = 0; k < table.header.size(); ++k)
    {
        text += isNumeric(table, k) ? "---:|" : "---|";
    }
    text += '\n';
    for (const auto& row : table.rows)
    {
        text += fmt::format("| {} |\n", joined(row, " | "));
    }
    return text;
}

std::string csvText(const TextTable& table)
{
    std::vector<std::string> header = table.header;
    for (std::string& name : header)
    {
        std::replace(name.begin(), name.end(), ' ', '_');
    }
    std::string text = fmt::format("{}\n", joined(header, ","));
    for (const auto& row : table.rows)
    {
        std::vector<std::string> cells;
        std::transform(row.begin(), row.end(), std::back_inserter(cells), csvCell);
        text += fmt::format("{}\n", joined(cells, ","));
    }
    return text;
}
}  // namespace bullet_ccd::tools
