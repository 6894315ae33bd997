#include "tools/support/help_format.h"

#include "bullet_ccd/io/nearest_name.h"
#include "tools/support/text_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <set>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::size_t kWidth = 80;
constexpr std::size_t kTextColumn = 26;

std::string_view nextPart(std::string_view& text, char separator)
{
    const std::size_t end = std::min(text.find(separator), text.size());
    const std::string_view part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return part;
}

std::string wrappedParagraph(std::string_view text, std::size_t indent)
{
    std::string lines;
    std::size_t column = indent;
    while (!text.empty())
    {
        const std::string_view word = nextPart(text, ' ');
        const bool isFirst = lines.empty();
        if (!isFirst && column + 1 + word.size() > kWidth)
        {
            lines += '\n' + std::string(indent, ' ');
            column = indent;
        }
        else if (!isFirst)
        {
            lines += ' ';
            ++column;
        }
        lines += word;
        column += word.size();
    }
    return lines;
}

/// A line of a list: a name, and what it means beside or below it.
std::string entry(const std::string& name, const std::string& text)
{
    std::string line = "  " + name;
    const std::string space(kTextColumn, ' ');
    line += line.size() + 2 > kTextColumn ? '\n' + space : space.substr(line.size());
    return line + wrapped(text, kTextColumn) + '\n';
}

/// Several values as the command line takes them, fractions with six digits.
std::string plainDefault(std::string text)
{
    if (double value = 0.0; text.size() > 8 && text.find('.') != std::string::npos &&
                            CLI::detail::lexical_cast(text, value))
    {
        return fmt::format("{:.6g}", value);
    }
    if (text.size() > 1 && text.front() == '[' && text.back() == ']')
    {
        text = text.substr(1, text.size() - 2);
        std::replace(text.begin(), text.end(), ',', ' ');
    }
    return text;
}

std::string upper(std::string text)
{
    std::transform(text.begin(),
                   text.end(),
                   text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

std::string namesOf(const std::set<CLI::Option*>& options)
{
    std::set<std::string> names;  // the options themselves are sorted by their addresses
    for (const CLI::Option* option : options)
    {
        names.insert(option->get_name());
    }
    return joined({names.begin(), names.end()}, ", ");
}

class HelpFormat : public CLI::Formatter
{
public:
    HelpFormat()
    {
        label("Positionals", "Arguments");
        label("SUBCOMMAND", "VERB");
    }

    std::string make_help(const CLI::App* app,
                          std::string name,
                          CLI::AppFormatMode mode) const override
    {
        return CLI::detail::find_and_replace(
            Formatter::make_help(app, name, mode), "\n\n\n", "\n\n");
    }

    std::string make_subcommands(const CLI::App* app, CLI::AppFormatMode mode) const override
    {
        return CLI::detail::find_and_replace(
            Formatter::make_subcommands(app, mode), "Subcommands:", "Verbs:");
    }

    std::string make_description(const CLI::App* app) const override
    {
        return wrapped(app->get_description(), 0) + "\n\n";
    }

    std::string make_footer(const CLI::App* app) const override
    {
        return app->get_footer().empty() ? std::string() : wrapped(app->get_footer(), 0) + '\n';
    }

    std::string make_subcommand(const CLI::App* verb) const override
    {
        return entry(verb->get_name(), verb->get_description());
    }

    std::string make_option_name(const CLI::Option* option, bool isPositional) const override
    {
        return isPositional ? upper(option->get_name(true, false)) : option->get_name(false, true);
    }

    std::string make_option(const CLI::Option* option, bool isPositional) const override
    {
        std::string name = make_option_name(option, isPositional);
        std::string text = option->get_description();
        if (option->get_type_size() != 0 && option->get_type_name() != name)  // no flag
        {
            name += ' ' + option->get_type_name();
        }
        if (option->get_required() && !isPositional)
        {
            text += " Required.";
        }
        if (const std::string value = plainDefault(option->get_default_str()); !value.empty())
        {
            text += fmt::format(" Default: {}.", value);
        }
        if (!option->get_needs().empty())
        {
            text += fmt::format(" Only with {}.", namesOf(option->get_needs()));
        }
        if (!option->get_excludes().empty())
        {
            text += fmt::format(" Not with {}.", namesOf(option->get_excludes()));
        }
        return entry(name, text);
    }
};

std::vector<std::string> optionNames(const CLI::App& verb)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : verb.get_options())
    {
        if (option->nonpositional())
        {
            names.push_back(option->get_name());
        }
    }
    return names;
}

std::vector<std::string> verbNames(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    {
        names.push_back(verb->get_name());
    }
    return names;
}

/// Of words that belong to nothing.
std::string complaint(const CLI::App& verb, const std::string& extra)
{
    const std::vector<std::string> verbs = verbNames(verb);
    if (extra.starts_with('-'))
    {
        return fmt::format(
            "{}: no such option: did you mean {}?", extra, nearestName(extra, optionNames(verb)));
    }
    return verbs.empty()
               ? fmt::format("{}: one argument too many: leave it out", extra)
               : fmt::format(
                     "{}: no such verb: did you mean {}?", extra, nearestName(extra, verbs));
}

/// Instead of what CLI11 says where that names no remedy.
std::string complaint(const CLI::App& verb, const CLI::Error& error)
{
    const std::string text = error.what();
    if (const std::vector<std::string> extra = verb.remaining(); !extra.empty())
    {
        return complaint(verb, extra[0]);
    }
    if (error.get_name() == "RequiredError" && text == "A subcommand is required")
    {
        return fmt::format("no verb: give one of {}", joined(verbNames(verb), ", "));
    }
    if (error.get_name() == "RequiredError" && !text.starts_with('-'))
    {
        return upper(text.substr(0, text.find(' '))) + text.substr(text.find(' '));
    }
    const std::string name = text.substr(0, text.find(':'));
    const CLI::Option* option = verb.get_option_no_throw(name);
    if (error.get_name() == "ArgumentMismatch" && option != nullptr)
    {
        return fmt::format(
            "{}: too few or too many values: give {} {}", name, name, option->get_type_name());
    }
    constexpr std::string_view kConversion = "Could not convert: ";
    if (error.get_name() == "ConversionError" && text.starts_with(kConversion))
    {
        return CLI::detail::find_and_replace(text.substr(kConversion.size()), " = ", ": ") +
               " is no value for it: see its help";
    }
    if (error.get_name() == "ExcludesError")
    {
        return text + ": leave out one of them";
    }
    return error.get_name() == "RequiresError" ? text + ": give both or none" : text;
}
}  // namespace

std::string wrapped(std::string_view text, std::size_t indent)
{
    std::string lines;
    bool isFirst = true;
    while (!text.empty())
    {
        const std::string_view paragraph = nextPart(text, '\n');
        lines += isFirst ? "" : "\n";
        lines += isFirst || paragraph.empty() ? "" : std::string(indent, ' ');
        lines += paragraph.starts_with(' ') ? std::string(paragraph)
                                            : wrappedParagraph(paragraph, indent);
        isFirst = false;
    }
    return lines;
}

std::shared_ptr<CLI::FormatterBase> helpFormat()
{
    return std::make_shared<HelpFormat>();
}

std::string usageError(const CLI::App& app, const CLI::Error& error)
{
    const CLI::App* verb = &app;
    std::string name = app.get_name();
    while (!verb->get_subcommands().empty())
    {
        verb = verb->get_subcommands().back();
        name += ' ' + verb->get_name();
    }
    return fmt::format(
        "{}: {}\n'{} --help' shows all options.\n", name, complaint(*verb, error), name);
}
}  // namespace bullet_ccd::tools
