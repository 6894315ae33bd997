/// Words and numbers of text files: what the readers of OBJ and OFF share.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace bullet_ccd
{
/// The number that `word` is or, if `prefixAllowed`, begins with before a slash.
template <class Number>
std::optional<Number> parseNumber(std::string_view word, bool prefixAllowed = false)
{
    if (!word.empty() && word.front() == '+')
    {
        word.remove_prefix(1);
    }
    Number value{};
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (error != std::errc{} || (stop != end && !(prefixAllowed && *stop == '/')))
    {
        return std::nullopt;
    }
    return value;
}

/// For messages: at most 30 printable characters, in quotes.
inline std::string quoted(std::string_view word)
{
    std::string text = "'";
    for (const char c : word.substr(0, 30))
    {
        text += c >= ' ' && c <= '~' ? c : '?';
    }
    text += '\'';
    return text;
}
}  // namespace bullet_ccd
