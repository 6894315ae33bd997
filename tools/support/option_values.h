/// Checks of option values that the programs share.
#pragma once

#include "tools/support/text_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
/// Accepts values from low to high, so never nan, which CLI::Range lets pass; the range shows in
/// errors, not in the help.
template <typename T>
[[nodiscard]] CLI::Validator within(T low, T high)
{
    return {[low, high](const std::string& text)
            {
                T value{};
                const bool fits =
                    CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
                return fits ? std::string()
                            : fmt::format("{} is not a number from {} to {}", text, low, high);
            },
            ""};
}

/// Accepts whole numbers from 0 of at most 64 bits. Plain conversion to an unsigned number would
/// wrap negative ones around, and take the largest one in place of what is too large.
[[nodiscard]] inline CLI::Validator wholeNumber()
{
    return {[](const std::string& text)
            {
                std::uint64_t value = 0;
                const char* const end = text.data() + text.size();
                const std::from_chars_result read = std::from_chars(text.data(), end, value);
                const bool fits = read.ec == std::errc() && read.ptr == end;
                return fits ? std::string()
                            : fmt::format("{} is not a whole number from 0 to {}",
                                          text,
                                          std::numeric_limits<std::uint64_t>::max());
            },
            ""};
}

/// Accepts one of the words, which show in errors, not in the help.
[[nodiscard]] inline CLI::Validator oneOf(const std::vector<std::string>& words)
{
    return {[words](const std::string& text)
            {
                return std::find(words.begin(), words.end(), text) != words.end()
                           ? std::string()
                           : fmt::format("{} is not one of {}", text, joined(words, ", "));
            },
            ""};
}

/// Turns a word into the enumerator that it stands for; the words show in errors, not in the help.
template <typename Enum>
[[nodiscard]] CLI::Validator wordFor(const std::vector<std::pair<std::string, Enum>>& words)
{
    return {[words](std::string& text)
            {
                std::vector<std::string> known;
                for (const auto& [word, value] : words)
                {
                    if (text == word)
                    {
                        text = std::to_string(static_cast<int>(value));
                        return std::string();
                    }
                    known.push_back(word);
                }
                return fmt::format("{} is not one of {}", text, joined(known, ", "));
            },
            ""};
}

/// Accepts what `parse` takes without an exception, whose text becomes the error.
template <typename Parse>
[[nodiscard]] CLI::Validator parsedBy(const Parse& parse)
{
    return {[parse](const std::string& text) -> std::string
            {
                try
                {
                    (void)parse(text);
                    return {};
                }
                catch (const std::invalid_argument& error)
                {
                    return error.what();
                }
            },
            ""};
}
}  // namespace bullet_ccd::tools
