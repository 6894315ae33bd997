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

namespace
{
/// Appends the cell whose opening quote is at `at`, and returns the place behind its closing quote;
/// npos without one.
std::size_t readQuoted(std::string_view line, std::size_t at, std::string& cell)
{
    for (std::size_t k = at + 1; k < line.size(); ++k)
    {
        if (line[k] == '"' && line.substr(k, 2) != "\"\"")
        {
            return k + 1;
        }
        cell += line[k];
        k += line[k] == '"' ? 1U : 0U;
    }
    return std::string_view::npos;
}
}  // namespace

std::optional<std::vector<std::string>> csvCells(std::string_view line)
{
    std::vector<std::string> cells;
    for (std::size_t at = 0; at <= line.size();)
    {
        std::string& cell = cells.emplace_back();
        const std::size_t start = line.find_first_not_of(" \t", at);
        const bool quoted = start != std::string_view::npos && line[start] == '"';
        const std::size_t rest = quoted ? readQuoted(line, start, cell) : at;
        if (rest == std::string_view::npos)
        {
            return std::nullopt;
        }
        const std::size_t comma = std::min(line.find(',', rest), line.size());
        const std::string_view text = trimmed(line.substr(rest, comma - rest));
        if (quoted && !text.empty())
        {
            return std::nullopt;
        }
        cell += text;
        at = comma + 1;
    }
    return cells;
}

std::string csvCell(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos && trimmed(text) == text)
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
