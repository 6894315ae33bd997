/// One call in a process of its own, which may crash or never return.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace bullet_ccd::benchmarks
{
enum class IsolatedEnd : std::uint8_t
{
    Finished,
    Crashed,   ///< by a signal, an exception or a bad exit
    TimedOut,  ///< ended from outside
};

struct IsolatedAnswer
{
    IsolatedEnd end = IsolatedEnd::Crashed;
    std::string text;  ///< what the call returned, if it finished
};

/// Makes the call in a child process and waits for its text, at most so long. Nothing that the call
/// does to this process' memory remains. Throws std::runtime_error if no process can be made.
[[nodiscard]] IsolatedAnswer runIsolated(double seconds, const std::function<std::string()>& call);
}  // namespace bullet_ccd::benchmarks
