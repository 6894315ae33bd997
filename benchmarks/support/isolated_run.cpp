#include "benchmarks/support/isolated_run.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <poll.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::benchmarks
{
namespace
{
[[noreturn]] void answer(int pipe, const std::function<std::string()>& call)
{
    try
    {
        const std::string text = call();
        std::size_t written = 0;
        while (written < text.size())
        {
            const ssize_t count = write(pipe, text.data() + written, text.size() - written);
            if (count < 0)
            {
                _exit(2);
            }
            written += static_cast<std::size_t>(count);
        }
        _exit(0);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "isolated run: %s\n", error.what());
        _exit(1);
    }
}

/// Everything up to the end of the pipe; false at the time limit.
bool readAll(int pipe, double seconds, std::string& text)
{
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    std::array<char, 4096> part{};
    while (true)
    {
        const double left = std::chrono::duration<double>(end - Clock::now()).count();
        pollfd wait{.fd = pipe, .events = POLLIN, .revents = 0};
        const int ready = poll(&wait, 1, static_cast<int>(1e3 * std::max(left, 0.0)));
        if (ready < 0 && errno == EINTR)
        {
            continue;
        }
        if (ready <= 0)
        {
            return false;
        }
        const ssize_t count = read(pipe, part.data(), part.size());
        if (count <= 0)
        {
            return true;
        }
        text.append(part.data(), static_cast<std::size_t>(count));
    }
}
}  // namespace

IsolatedAnswer runIsolated(double seconds, const std::function<std::string()>& call)
{
    std::fflush(nullptr);  // or the child would print it again
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0)
    {
        throw std::runtime_error("isolated run: no pipe: close other programs");
    }
    const pid_t child = fork();
    if (child < 0)
    {
        close(ends[0]);
        close(ends[1]);
        throw std::runtime_error("isolated run: no child process: close other programs");
    }
    if (child == 0)
    {
        close(ends[0]);
        answer(ends[1], call);
    }
    close(ends[1]);
    IsolatedAnswer result;
    const bool isDone = readAll(ends[0], seconds, result.text);
    close(ends[0]);
    if (!isDone)
    {
        kill(child, SIGKILL);
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    {
    }
    if (!isDone)
    {
        result.end = IsolatedEnd::TimedOut;
    }
    else if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
    {
        result.end = IsolatedEnd::Finished;
    }
    return result;
}
}  // namespace bullet_ccd::benchmarks
