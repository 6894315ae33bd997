/// Small tables for people and for files.
#pragma once

#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct TextTable
{
    std::vector<std::string> header;
    std::vector<std::vector<std::string>> rows;  ///< as many cells as the header
};

/// The texts with `separator` between them.
[[nodiscard]] std::string joined(const std::vector<std::string>& texts,
                                 const std::string& separator);

/// Columns aligned by spaces; columns of numbers to the right. Ends with a newline.
[[nodiscard]] std::string alignedText(const TextTable& table);
[[nodiscard]] std::string markdownText(const TextTable& table);
/// RFC 4180, with a header line; spaces of the header become underscores.
[[nodiscard]] std::string csvText(const TextTable& table);
}  // namespace bullet_ccd::tools
