/// Command lines of the programs that measure.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace CLI
{
class App;
}

namespace bullet_ccd::benchmarks
{
/// Where the value of an option goes; what is there already is the default.
using OptionValue = std::variant<bool*,
                                 int*,
                                 std::uint64_t*,
                                 double*,
                                 std::string*,
                                 std::filesystem::path*,
                                 std::vector<int>*,
                                 std::vector<std::string>*>;

struct ProgramOption
{
    std::string names;  ///< such as "-n,--count"; "!--no-fcl" is a flag that clears its value
    OptionValue value;
    std::string help;
    int least = 1;  ///< of int and of each of several; double must be positive
    bool isRequired = false;
};

/// A program, or one of its verbs.
struct Program
{
    std::string name;
    std::string about;
    std::vector<ProgramOption> options;
    /// Returns whether all that must hold does.
    std::function<bool()> run = nullptr;
    std::vector<Program> verbs{};  ///< one of which must be given
    /// Adds what other command lines have, too; may set a footer.
    std::function<void(CLI::App& app)> extend = nullptr;
};

/// Reads the command line, then runs the program or the verb that was given.
/// @return exit code: 0 if all that must hold does, 1 if not, 2 for usage and exceptions, whose
///         messages go to stderr with the name of the program
[[nodiscard]] int runProgram(int argc, char** argv, const Program& program);

/// Those whose name contains the text of --only. Throws std::invalid_argument, which names all, if
/// there is none.
template <typename Named>
std::vector<Named> only(std::vector<Named> all, const std::string& text)
{
    std::string names;
    for (const Named& one : all)
    {
        names += "\n  " + std::string(one.name);
    }
    std::erase_if(all, [&](const Named& one) { return one.name.find(text) == std::string::npos; });
    if (all.empty())
    {
        throw std::invalid_argument("--only " + text + ": none has this in its name; there are" +
                                    names);
    }
    return all;
}
}  // namespace bullet_ccd::benchmarks
