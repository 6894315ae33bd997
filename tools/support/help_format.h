/// How the help and the errors of command lines look.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace CLI
{
class App;
class Error;
class FormatterBase;
}  // namespace CLI

namespace bullet_ccd::tools
{
/// Lines of at most 80 columns, broken at spaces, all but the first behind `indent` spaces. Every
/// line of the text is a paragraph; those that begin with a space, such as examples and tables,
/// stay as they are.
[[nodiscard]] std::string wrapped(std::string_view text, std::size_t indent);

/// For CLI::App::formatter(). The text of an option is full sentences without default, which is
/// added.
[[nodiscard]] std::shared_ptr<CLI::FormatterBase> helpFormat();

/// For CLI::App::failure_message(): "<program> <verb>: <option>: <what, value>: <remedy>", and how
/// to see the help.
[[nodiscard]] std::string usageError(const CLI::App& app, const CLI::Error& error);
}  // namespace bullet_ccd::tools
