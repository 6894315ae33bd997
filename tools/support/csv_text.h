/// Lines of CSV files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::tools
{
/// `text` without white space at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// The cells of one line, without the spaces around them; nullopt if a quote is not closed or
/// text follows it. RFC 4180, except that no cell goes on in the next line.
[[nodiscard]] std::optional<std::vector<std::string>> csvCells(std::string_view line);

/// All of a file. Throws std::runtime_error "<path>: <what>: <remedy>" if it cannot be read.
[[nodiscard]] std::string contentOfFile(const std::filesystem::path& path,
                                        const std::string& remedy);

struct NumberedLine
{
    std::string_view text;
    std::size_t line = 0;  ///< in the file, from 1
};

/// The lines of the content that are not empty; line ends of any system, a byte order mark is
/// skipped.
[[nodiscard]] std::vector<NumberedLine> linesOf(std::string_view content);

/// The cell as it is written into a CSV file: in quotes if it has to be.
[[nodiscard]] std::string csvCell(const std::string& text);
}  // namespace bullet_ccd::tools
