#include "benchmarks/support/sandbox.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Before every answer in the pipe.
struct Header
{
    double seconds = 0.0;
    std::size_t size = 0;
    bool isException = false;
};

double processorSeconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Ends this process by SIGPROF after so many seconds of processor time from now.
void endAfter(double seconds)
{
    itimerval timer{};
    timer.it_value.tv_sec = static_cast<time_t>(seconds);
    timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - std::floor(seconds)));
    setitimer(ITIMER_PROF, &timer, nullptr);
}

void writeAll(int pipe, const void* data, std::size_t size)
{
    const char* next = static_cast<const char*>(data);
    while (size > 0)
    {
        const ssize_t count = write(pipe, next, size);
        if (count < 0)
        {
            _exit(2);
        }
        next += count;
        size -= static_cast<std::size_t>(count);
    }
}

/// Child: answers from `first` on until one call fails.
[[noreturn]] void answerFrom(std::size_t first,
                             std::size_t count,
                             const SandboxLimits& limits,
                             const std::function<std::string(std::size_t)>& call,
                             int pipe)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    for (std::size_t i = first; i < count; ++i)
    {
        Header header;
        std::string text;
        endAfter(limits.seconds);
        const double start = processorSeconds();
        try
        {
            text = call(i);
        }
        catch (const std::exception& error)
        {
            header.isException = true;
            text = error.what();
        }
        header.seconds = processorSeconds() - start;
        header.size = text.size();
        writeAll(pipe, &header, sizeof header);
        writeAll(pipe, text.data(), text.size());
        if (header.isException)
        {
            _exit(1);
        }
    }
    _exit(0);
}

/// False at the end of the pipe, or if the child says nothing for so long; it is ended then.
bool readAll(int pipe, void* data, std::size_t size, double patience, pid_t child)
{
    char* next = static_cast<char*>(data);
    while (size > 0)
    {
        pollfd waiting{.fd = pipe, .events = POLLIN, .revents = 0};
        const int ready = poll(&waiting, 1, static_cast<int>(1e3 * patience));
        if (ready < 0 && errno == EINTR)
        {
            continue;
        }
        if (ready <= 0)
        {
            kill(child, SIGPROF);
            return false;
        }
        const ssize_t count = read(pipe, next, size);
        if (count <= 0)
        {
            return false;
        }
        next += count;
        size -= static_cast<std::size_t>(count);
    }
    return true;
}

/// Adds the answers of a child up to and with the call that ends it.
void runChild(std::size_t count,
              const SandboxLimits& limits,
              const std::function<std::string(std::size_t)>& call,
              std::vector<Sandboxed<std::string>>& answers)
{
    std::fflush(nullptr);  // or the child would print it again
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0)
    {
        throw std::runtime_error("no pipe to a child process: close other programs");
    }
    const pid_t child = fork();
    if (child < 0)
    {
        close(ends[0]);
        close(ends[1]);
        throw std::runtime_error("no child process can be started: close other programs");
    }
    if (child == 0)
    {
        close(ends[0]);
        answerFrom(answers.size(), count, limits, call, ends[1]);
    }
    close(ends[1]);
    const double patience = 20.0 * limits.seconds;
    bool goesOn = true;
    while (goesOn && answers.size() < count)
    {
        Sandboxed<std::string> one;
        Header header;
        goesOn = readAll(ends[0], &header, sizeof header, patience, child);
        one.answer.resize(header.size);
        goesOn = goesOn && readAll(ends[0], one.answer.data(), header.size, patience, child);
        if (goesOn && header.isException)
        {
            std::fprintf(stderr, "sandbox: %s\n", one.answer.c_str());
            goesOn = false;
        }
        one.end = goesOn ? SandboxEnd::Answered : SandboxEnd::Crashed;
        one.seconds = header.seconds;
        answers.push_back(std::move(one));
    }
    close(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    {
    }
    if (!goesOn && WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF)
    {
        answers.back().end = SandboxEnd::TimedOut;
        answers.back().seconds = limits.seconds;
    }
}
}  // namespace

std::vector<Sandboxed<std::string>> runSandboxed(
    std::size_t count,
    const SandboxLimits& limits,
    const std::function<std::string(std::size_t)>& call)
{
    std::vector<Sandboxed<std::string>> answers;
    int timedOut = 0;
    while (answers.size() < count && timedOut < limits.patience)
    {
        runChild(count, limits, call, answers);
        timedOut += answers.back().end == SandboxEnd::TimedOut ? 1 : 0;
    }
    return answers;
}
}  // namespace bullet_ccd::benchmarks
