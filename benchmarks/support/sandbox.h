/// Calls that may crash or never return, made in processes of their own.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <type_traits>

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

/// Makes a call in a child process; nothing that it does to the memory of this process remains.
/// What it prints is dropped; the message of an exception goes to standard error. Throws
/// std::runtime_error if no process can be made.
/// @param limit  processor time of the call [s]; one that sleeps is ended after twenty times that
[[nodiscard]] Sandboxed<std::string> runSandboxed(double limit,
                                                  const std::function<std::string()>& call);

template <typename Answer>
[[nodiscard]] std::string bytesOf(const Answer& answer)
{
    static_assert(std::is_trivially_copyable_v<Answer>);
    return {reinterpret_cast<const char*>(&answer), sizeof answer};
}

/// The same for an answer that is plain data.
template <typename Answer, typename Call>
[[nodiscard]] Sandboxed<Answer> sandboxedAnswer(double limit, const Call& call)
{
    const Sandboxed<std::string> bytes =
        runSandboxed(limit, [&] { return bytesOf<Answer>(call()); });
    Sandboxed<Answer> one{.end = bytes.end, .seconds = bytes.seconds};
    if (one.end == SandboxEnd::Answered)
    {
        std::memcpy(&one.answer, bytes.answer.data(), sizeof(Answer));
    }
    return one;
}
}  // namespace bullet_ccd::benchmarks
