#include "benchmarks/support/sandbox.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fcntl.h>
#include <stdexcept>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::benchmarks
{
namespace
{
double processorSeconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Ends this process by SIGPROF after so many seconds of processor time from now, and by SIGALRM
/// after twenty times that.
void endAfter(double seconds)
{
    itimerval timer{};
    timer.it_value.tv_sec = static_cast<time_t>(seconds);
    timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - std::floor(seconds)));
    setitimer(ITIMER_PROF, &timer, nullptr);
    alarm(static_cast<unsigned>(std::ceil(20.0 * seconds)));
}

void writeAll(int pipe, const std::string& text)
{
    for (std::size_t done = 0; done < text.size();)
    {
        const ssize_t count = write(pipe, text.data() + done, text.size() - done);
        if (count < 0)
        {
            _exit(2);
        }
        done += static_cast<std::size_t>(count);
    }
}

/// Child: the processor time of the call, then its answer.
[[noreturn]] void answer(const std::function<std::string()>& call, double limit, int pipe)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    const int messages = dup(STDERR_FILENO);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    endAfter(limit);
    const double start = processorSeconds();
    try
    {
        const std::string text = call();
        const double seconds = processorSeconds() - start;
        writeAll(pipe, bytesOf(seconds) + text);
        _exit(0);
    }
    catch (const std::exception& error)
    {
        dprintf(messages, "sandbox: %s\n", error.what());
        _exit(1);
    }
}

}  // namespace

Sandboxed<std::string> runSandboxed(double limit, const std::function<std::string()>& call)
{
    std::fflush(nullptr);  // or the child would print it again
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0)
    {
        throw std::runtime_error("no pipe to a child process: close other programs");
    }
    const pid_t child = fork();
    if (child == 0)
    {
        close(ends[0]);
        answer(call, limit, ends[1]);
    }
    close(ends[1]);
    std::string said;
    std::array<char, 4096> part{};
    for (ssize_t count = 1; child > 0 && count != 0;)
    {
        count = read(ends[0], part.data(), part.size());
        said.append(part.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        count = count < 0 && errno != EINTR ? 0 : count;
    }
    close(ends[0]);
    if (child < 0)
    {
        throw std::runtime_error("no child process can be started: close other programs");
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    {
    }
    Sandboxed<std::string> one;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && said.size() >= sizeof one.seconds)
    {
        one.end = SandboxEnd::Answered;
        std::memcpy(&one.seconds, said.data(), sizeof one.seconds);
        one.answer = said.substr(sizeof one.seconds);
    }
    else if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGALRM))
    {
        one = {.end = SandboxEnd::TimedOut, .answer = {}, .seconds = limit};
    }
    return one;
}
}  // namespace bullet_ccd::benchmarks
