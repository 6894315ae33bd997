#include "tools/support/csv_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <stdexcept>

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

std::string contentOfFile(const std::filesystem::path& path, const std::string& remedy)
{
    namespace fs = std::filesystem;
    std::ifstream file(path, std::ios::binary);
    if (!file || fs::is_directory(path))
    {
        throw std::runtime_error(fmt::format(
            "{}: {}: {}",
            path.string(),
            fs::is_directory(path) ? "is a folder"
                                   : (fs::exists(path) ? "cannot be read" : "does not exist"),
            remedy));
    }
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<NumberedLine> linesOf(std::string_view content)
{
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (content.substr(0, kByteOrderMark.size()) == kByteOrderMark)
    {
        content.remove_prefix(kByteOrderMark.size());
    }
    std::vector<NumberedLine> lines;
    for (std::size_t line = 1; !content.empty(); ++line)
    {
        const std::size_t end = std::min(content.find_first_of("\r\n"), content.size());
        const std::string_view text = content.substr(0, end);
        content.remove_prefix(end);
        content.remove_prefix(
            content.substr(0, 2) == "\r\n" ? 2 : std::min<std::size_t>(1, content.size()));
        if (!trimmed(text).empty())
        {
            lines.push_back({.text = text, .line = line});
        }
    }
    return lines;
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
