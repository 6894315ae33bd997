#include "tools/support/command_line.h"

#include "tools/support/help_format.h"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <iostream>
#include <system_error>

namespace bullet_ccd::tools
{
namespace
{
/// Ends the output; kBadInput, with a message, if some of it could not be written.
int endOutput(const char* program, int exitCode)
{
    errno = 0;
    std::cout.flush();
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good())
    {
        return exitCode;
    }
    fmt::print(stderr,
               "{}: the output cannot be written{}: write it elsewhere\n",
               program,
               errno == 0 ? "" : " (" + std::generic_category().message(errno) + ")");
    return kBadInput;
}
}  // namespace

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
        return app.exit(error) == 0 ? endOutput(text.name, kDone) : kUsage;
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "{}: {}\n", text.name, error.what());
        return kBadInput;
    }
    return endOutput(text.name, exitCode);
}
}  // namespace bullet_ccd::tools
