/// Calls that may crash or never return, made in processes of their own.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace bullet_ccd::benchmarks
{
enum class SandboxEnd : std::uint8_t
{
    Answered,
    Crashed,   ///< by a signal, an exception or an exit
    TimedOut,  ///< ended from outside
};

template <typename Answer>
struct Sandboxed
{
    SandboxEnd end = SandboxEnd::Crashed;
    Answer answer = {};    ///< means nothing unless the call has answered
    double seconds = 0.0;  ///< of processor time; the limit if it has timed out
};

struct SandboxLimits
{
    /// Of processor time for each call [s]. A call that sleeps is ended after twenty times that.
    double seconds = 60.0;
    /// After so many calls that took too long the rest is not made.
    int patience = std::numeric_limits<int>::max();
};

/// Makes calls 0 .. count - 1 one after the other in a child process, and goes on in a new one
/// after a call that ends it; nothing that a call does to the memory of this process remains. What
/// calls print is dropped; the message of an exception goes to standard error. The result is
/// shorter than `count` only where patience ends. Throws std::runtime_error if no process can be
/// made.
[[nodiscard]] std::vector<Sandboxed<std::string>> runSandboxed(
    std::size_t count,
    const SandboxLimits& limits,
    const std::function<std::string(std::size_t)>& call);

/// The same for answers that are plain data.
template <typename Answer, typename Call>
[[nodiscard]] std::vector<Sandboxed<Answer>> sandboxedAnswers(std::size_t count,
                                                              const SandboxLimits& limits,
                                                              const Call& call)
{
    static_assert(std::is_trivially_copyable_v<Answer>);
    const auto bytesOf = [&](std::size_t i)
    {
        const Answer answer = call(i);
        return std::string(reinterpret_cast<const char*>(&answer), sizeof answer);
    };
    std::vector<Sandboxed<Answer>> answers;
    for (const Sandboxed<std::string>& one : runSandboxed(count, limits, bytesOf))
    {
        answers.push_back({.end = one.end, .seconds = one.seconds});
        if (one.end == SandboxEnd::Answered)
        {
            std::memcpy(&answers.back().answer, one.answer.data(), sizeof(Answer));
        }
    }
    return answers;
}
}  // namespace bullet_ccd::benchmarks
