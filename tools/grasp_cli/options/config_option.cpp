#include "tools/grasp_cli/options/config_option.h"

#include "bullet_ccd/io/nearest_name.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <stdexcept>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::tools
{
namespace
{
constexpr const char* kNoValue = ": no value: write one or drop the key";

bool isFlag(const CLI::Option& option)
{
    return option.get_items_expected_max() == 0;
}

/// One file; every error names the line of what is wrong.
class ConfigFile
{
public:
    ConfigFile(const std::string& path, const std::vector<CLI::Option*>& options)
        : m_path(path), m_options(options)
    {
    }

    /// Gives their values to the options that the command line left alone.
    void apply() const
    {
        const YAML::Node file = load();
        if (file.IsNull())
        {
            return;
        }
        if (!file.IsMap())
        {
            fail(file, "not a map: write KEY: VALUE, one a line");
        }
        std::vector<const CLI::Option*> seen;
        for (const auto& entry : file)
        {
            CLI::Option& option = optionOf(entry.first);
            if (std::ranges::find(seen, &option) != seen.end())
            {
                fail(entry.first, option.get_single_name() + ": there twice: drop one");
            }
            seen.push_back(&option);
            if (entry.second.IsNull())
            {
                fail(entry.first, option.get_single_name() + kNoValue);
            }
            if (option.count() == 0)
            {
                give(option, entry.second);
            }
        }
    }

private:
    [[nodiscard]] YAML::Node load() const
    {
        try
        {
            return YAML::LoadFile(m_path);
        }
        catch (const YAML::BadFile&)
        {
            throw std::runtime_error(
                m_path + ": cannot be read: give a YAML file, such as --print-config writes");
        }
        catch (const YAML::Exception& error)
        {
            throw std::runtime_error(fmt::format(
                "{}:{}: not YAML: {}: correct the line", m_path, error.mark.line + 1, error.msg));
        }
    }

    [[nodiscard]] CLI::Option& optionOf(const YAML::Node& node) const
    {
        const std::string key = node.IsScalar() ? node.Scalar() : "";
        std::vector<std::string> known;
        for (CLI::Option* option : m_options)
        {
            if (option->get_single_name() == key || option->check_lname(key))
            {
                return *option;
            }
            known.push_back(option->get_single_name());
        }
        fail(node, fmt::format("{}: no such key: did you mean {}?", key, nearestName(key, known)));
    }

    void give(CLI::Option& option, const YAML::Node& node) const
    {
        option.add_result(isFlag(option) ? std::vector{flagText(option, node)}
                                         : texts(option, node));
        try
        {
            option.run_callback();
        }
        catch (const CLI::ParseError& error)
        {
            fail(node, error.what());  // which begins with the name of the option
        }
    }

    [[nodiscard]] std::string flagText(const CLI::Option& option, const YAML::Node& node) const
    {
        bool value = false;
        if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value))
        {
            fail(node, option.get_single_name() + ": neither true nor false: write one of them");
        }
        return value ? "true" : "false";
    }

    [[nodiscard]] std::vector<std::string> texts(const CLI::Option& option,
                                                 const YAML::Node& node) const
    {
        std::vector<std::string> texts;
        for (std::size_t k = 0; node.IsSequence() && k < node.size(); ++k)
        {
            texts.push_back(text(option, node[k]));
        }
        if (!node.IsSequence())
        {
            texts.push_back(text(option, node));
        }
        const int count = static_cast<int>(texts.size());
        const int least = std::max(1, option.get_items_expected_min());
        const int most = option.get_items_expected_max();
        if (count < least || count > most)
        {
            const std::string needed = least == most   ? std::to_string(least)
                                       : count < least ? fmt::format("at least {}", least)
                                                       : fmt::format("at most {}", most);
            fail(node,
                 fmt::format("{}: {} value{} where {} {} needed: {}",
                             option.get_single_name(),
                             count,
                             count == 1 ? "" : "s",
                             needed,
                             needed == "1" ? "is" : "are",
                             least == 1 ? "write one" : "write a list, [A, B, ...]"));
        }
        return texts;
    }

    [[nodiscard]] std::string text(const CLI::Option& option, const YAML::Node& node) const
    {
        if (!node.IsScalar() || node.Scalar().empty())
        {
            fail(node, option.get_single_name() + kNoValue);
        }
        return node.Scalar();
    }

    [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const
    {
        throw std::runtime_error(
            fmt::format("{}:{}: {}", m_path, std::max(node.Mark().line, 0) + 1, what));
    }

    const std::string& m_path;
    const std::vector<CLI::Option*>& m_options;
};

/// Values as the user wrote them: the checks of some options turn words into numbers.
using Written = std::map<const CLI::Option*, std::vector<std::string>>;

void emit(YAML::Emitter& out, const CLI::Option& option, const std::vector<std::string>& values)
{
    out << YAML::Key << option.get_single_name() << YAML::Value;
    if (option.get_items_expected_max() > 1)
    {
        out << YAML::Flow << values;
    }
    else
    {
        out << values.back();
    }
}

std::string effectiveConfig(const std::vector<CLI::Option*>& options, const Written& written)
{
    YAML::Emitter out;
    out << YAML::BeginMap;
    for (const CLI::Option* option : options)
    {
        const auto values = written.find(option);
        if (values != written.end())
        {
            emit(out, *option, values->second);
        }
        else if (isFlag(*option))
        {
            emit(out, *option, {"false"});
        }
        else if (const std::string& text = option->get_default_str(); !text.empty())
        {
            // CLI11 writes several values as [A,B].
            const bool isList = text.front() == '[';
            emit(out,
                 *option,
                 CLI::detail::split(isList ? text.substr(1, text.size() - 2) : text,
                                    isList ? ',' : option->get_delimiter()));
        }
    }
    out << YAML::EndMap;
    return out.c_str();
}
}  // namespace

void addConfigOptions(CLI::App& command)
{
    for (CLI::App* below : command.get_subcommands([](CLI::App*) { return true; }))
    {
        addConfigOptions(*below);
    }
    const auto written = std::make_shared<Written>();
    const std::vector<CLI::Option*> options = command.get_options(
        [&](const CLI::Option* option) { return option != command.get_help_ptr(); });
    for (CLI::Option* option : options)
    {
        option->transform(CLI::Validator(
            [option, written](std::string& text)
            {
                (*written)[option].push_back(text);
                return std::string();
            },
            ""));
    }
    command
        .add_option_function<std::string>(
            "--config",
            [options](const std::string& file) { ConfigFile(file, options).apply(); },
            "Read options from a YAML map. Its keys are the long names without dashes; repeated "
            "options are lists. What the command line gives wins.")
        ->type_name("FILE")
        ->group("Configuration");
    // Stands last, so that all other options have been looked at when its turn comes.
    command
        .add_flag_callback(
            "--print-config",
            [options, written]
            {
                fmt::print("{}\n", effectiveConfig(options, *written));
                throw CLI::Success();
            },
            "Print all options as such a file, and stop.")
        ->group("Configuration");
}
}  // namespace bullet_ccd::tools
