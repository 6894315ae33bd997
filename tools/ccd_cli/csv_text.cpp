#include "tools/ccd_cli/csv_text.h"

#include <algorithm>

namespace bullet_ccd::tools
{
std::string_view trimmed(std::string_view text)
{
    constexpr std::string_view kSpace = " \t\r\n\v\f";
    const std::size_t first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos)
    {
        return {};
    }
    return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::optional<std::vector<std::string>> csvCells(std::string_view line)
{
    std::vector<std::string> cells;
    std::size_t at = 0;
    while (true)
    {
        std::string cell;
        const std::size_t start = std::min(line.find_first_not_of(" \t", at), line.size());
        if (start < line.size() && line[start] == '"')
        {
            std::size_t k = start + 1;
            for (; k < line.size() && (line[k] != '"' || line.substr(k, 2) == "\"\""); ++k)
            {
                cell += line[k];
                k += line[k] == '"' ? 1U : 0U;
            }
            if (k >= line.size())
            {
                return std::nullopt;
            }
            at = std::min(line.find(',', k), line.size());
        }
        else
        {
            const std::size_t comma = std::min(line.find(',', at), line.size());
            cell = trimmed(line.substr(at, comma - at));
            at = comma;
        }
        cells.push_back(std::move(cell));
        if (at >= line.size())
        {
            return cells;
        }
        ++at;
    }
}

std::string csvCell(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos)
    {
        return text;
    }
    std::string quoted = "\"";
    for (const char c : text)
    {
        quoted += c == '"' ? "\"\"" : std::string(1, c);
    }
    return quoted + "\"";
}
}  // namespace bullet_ccd::tools
