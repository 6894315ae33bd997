#include "bullet_ccd/io/child_process.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <poll.h>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd
{
namespace
{
/// Of waiting; a child that works is stopped by its processor time long before.
constexpr std::chrono::seconds kTimeLimit{3};

void setLimit(decltype(RLIMIT_CPU) resource, rlim_t value)
{
    const rlimit limit{value, value};
    static_cast<void>(::setrlimit(resource, &limit));
}

/// A crash is expected: no core file. Endless loops and allocations end as crashes.
void limitSelf(std::size_t inputBytes)
{
    constexpr rlim_t kMiB = 1U << 20U;
    const rlim_t input = inputBytes / kMiB;
    setLimit(RLIMIT_CORE, 0);
    setLimit(RLIMIT_CPU, 2 + 2 * input);
    // What the parent has mapped already counts too.
    rlim_t pages = 0;
    if (std::ifstream("/proc/self/statm") >> pages)
    {
        const auto pageSize = static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
        setLimit(RLIMIT_AS, pages * pageSize + (2048 + 64 * input) * kMiB);
    }
}

/// In the child: sends the result and ends without running anything of the parent's.
[[noreturn]] void work(const std::function<std::string()>& task, std::size_t inputBytes, int pipe)
{
    limitSelf(inputBytes);
    for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL})
    {
        static_cast<void>(std::signal(signal, SIG_DFL));
    }
    const std::string result = task();
    std::size_t sent = 0;
    while (sent < result.size())
    {
        const ssize_t count = ::write(pipe, result.data() + sent, result.size() - sent);
        if (count < 0 && errno != EINTR)
        {
            ::_exit(1);
        }
        sent += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    ::_exit(0);
}

/// Everything up to the end of the pipe, or up to the time limit; true if the end was reached.
bool readAll(int pipe, std::string& bytes)
{
    const auto deadline = std::chrono::steady_clock::now() + kTimeLimit;
    char buffer[1 << 16];
    while (true)
    {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
            deadline - std::chrono::steady_clock::now());
        pollfd ready{.fd = pipe, .events = POLLIN, .revents = 0};
        const int events = left.count() > 0 ? ::poll(&ready, 1, static_cast<int>(left.count())) : 0;
        if (events == 0)
        {
            return false;
        }
        const ssize_t count = events > 0 ? ::read(pipe, buffer, sizeof(buffer)) : -1;
        if (count == 0 || (count < 0 && errno != EINTR))
        {
            return true;
        }
        bytes.append(buffer, count > 0 ? static_cast<std::size_t>(count) : 0);
    }
}
}  // namespace

std::string runInChild(const std::function<std::string()>& task,
                       std::size_t inputBytes,
                       const std::string& name)
{
    int pipe[2];
    if (::pipe(pipe) != 0)
    {
        throw std::runtime_error(name + ": no pipe for the reader: close some files");
    }
    const pid_t child = ::fork();
    if (child == 0)
    {
        ::close(pipe[0]);
        work(task, inputBytes, pipe[1]);
    }
    ::close(pipe[1]);
    std::string result;
    const bool isComplete = child > 0 && readAll(pipe[0], result);
    ::close(pipe[0]);
    if (child < 0)
    {
        throw std::runtime_error(name + ": no process for the reader: end some processes");
    }
    if (!isComplete)
    {
        ::kill(child, SIGKILL);
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR)
    {
    }
    if (!isComplete)
    {
        throw std::runtime_error(name +
                                 ": reading does not end: "
                                 "export the mesh again, as OBJ if possible");
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || result.empty())
    {
        throw std::runtime_error(name +
                                 ": the file breaks the reader of its format: export the "
                                 "mesh again, as OBJ if possible");
    }
    return result;
}
}  // namespace bullet_ccd
