#include "tools/support/command_line.h"

#include "tools/support/help_format.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fmt/format.h>

namespace bullet_ccd::tools
{
int runProgram(int argc,
               char** argv,
               const ProgramText& text,
               const std::function<void(CLI::App& app, int& exitCode)>& addTo)
{
    int exitCode = kDone;
    CLI::App app(text.about, text.name);
    try
    {
        app.set_help_flag("-h,--help", "Print this help, and stop.");
        app.set_version_flag("--version",
                             fmt::format("{} {}", text.name, BULLET_CCD_VERSION),
                             "Print the version, and stop.");
        app.footer(text.footer);
        app.formatter(helpFormat());
        app.failure_message([](const CLI::App* failed, const CLI::Error& error)
                            { return usageError(*failed, error); });
        addTo(app, exitCode);
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? kDone : kUsage;
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "{}: {}\n", text.name, error.what());
        return kBadInput;
    }
    return exitCode;
}
}  // namespace bullet_ccd::tools
