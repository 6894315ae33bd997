/// Runs programs as a user does.
#pragma once

#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <sstream>
#include <string>
#include <sys/wait.h>

namespace bullet_ccd::tools
{
inline std::string contentOf(const std::filesystem::path& path)
{
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

struct Outcome
{
    int exitCode = -1;
    std::string out;
    std::string err;
};

/// `command` is a line for the shell.
inline Outcome runProgram(const std::string& command)
{
    const tests::TempFolder folder;
    const std::filesystem::path errors = folder.path() / "stderr.txt";
    Outcome outcome;
    std::FILE* pipe = ::popen((command + " 2> '" + errors.string() + "'").c_str(), "r");
    std::array<char, 4096> buffer{};
    for (std::size_t got = 1; got > 0;)
    {
        got = std::fread(buffer.data(), 1, buffer.size(), pipe);
        outcome.out.append(buffer.data(), got);
    }
    const int status = ::pclose(pipe);
    outcome.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.err = contentOf(errors);
    return outcome;
}

/// A terminal of 80 columns shows all of it, and it says the exit codes and an example.
inline void expectReadableHelp(const std::string& help)
{
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);)
    {
        EXPECT_LE(line.size(), 80U) << line;
    }
    EXPECT_THAT(help, ::testing::HasSubstr("Exit codes: 0 "));
    EXPECT_THAT(help, ::testing::HasSubstr("Example"));
    EXPECT_THAT(help, ::testing::Not(::testing::HasSubstr("REQUIRED")));
}
}  // namespace bullet_ccd::tools
