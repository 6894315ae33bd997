#include "benchmarks/support/program.h"

#include "tools/support/option_values.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <type_traits>

namespace bullet_ccd::benchmarks
{
namespace
{
void add(CLI::App& app, const ProgramOption& option)
{
    const auto addValue = [&](auto* value)
    {
        using Value = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, bool>)
        {
            app.add_flag(option.names, *value, option.help);
        }
        else
        {
            CLI::Option* added =
                app.add_option(option.names, *value, option.help)->required(option.isRequired);
            if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, std::vector<int>>)
            {
                added->check(
                    tools::within(std::int64_t{option.least}, std::int64_t{1'000'000'000}));
            }
            if constexpr (std::is_same_v<Value, double>)
            {
                added->check(tools::within(1e-12, 1e12));
            }
            if constexpr (std::is_same_v<Value, std::vector<std::string>>)
            {
                added->delimiter(',');
            }
            if (!option.isRequired)
            {
                added->capture_default_str();
            }
        }
    };
    std::visit(addValue, option.value);
}

void add(CLI::App& app, const Program& program, bool& holds)
{
    for (const ProgramOption& option : program.options)
    {
        add(app, option);
    }
    for (const Program& verb : program.verbs)
    {
        add(*app.add_subcommand(verb.name, verb.about), verb, holds);
    }
    if (program.extend)
    {
        program.extend(app);
    }
    if (program.run)
    {
        app.callback([&] { holds = program.run(); });
    }
    app.require_subcommand(program.verbs.empty() ? 0 : 1);
}
}  // namespace

int runProgram(int argc, char** argv, const Program& program)
{
    bool holds = true;
    CLI::App app(program.about, program.name);
    app.footer("Exit codes: 0 all that must hold does, 1 not, 2 usage or missing files.");
    try
    {
        add(app, program, holds);
        app.parse(argc, argv);
        return holds ? 0 : 1;
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : 2;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "%s: %s\n", program.name.c_str(), error.what());
        return 2;
    }
}
}  // namespace bullet_ccd::benchmarks
