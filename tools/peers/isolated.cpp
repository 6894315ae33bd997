#include "tools/peers/isolated.h"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::tests
{
namespace
{
[[noreturn]] void answerInto(int pipe, const std::function<PeerAnswer()>& code)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    try
    {
        const PeerAnswer answer = code();
        const ssize_t written = write(pipe, &answer, sizeof(answer));
        _exit(written == static_cast<ssize_t>(sizeof(answer)) ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    catch (...)
    {
        _exit(EXIT_FAILURE);
    }
}
}  // namespace

IsolatedAnswer runIsolated(const std::function<PeerAnswer()>& code, double limit)
{
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0)
    {
        throw std::runtime_error("no pipe to a child process: too many open files?");
    }
    const auto start = std::chrono::steady_clock::now();
    const pid_t child = fork();
    if (child < 0)
    {
        throw std::runtime_error("no child process can be started: too many processes?");
    }
    if (child == 0)
    {
        close(ends[0]);
        answerInto(ends[1], code);
    }
    close(ends[1]);
    IsolatedAnswer result;
    pollfd waiting{.fd = ends[0], .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, static_cast<int>(1000.0 * limit)) == 0)
    {
        kill(child, SIGKILL);
        result.ending = Ending::TimedOut;
    }
    else if (read(ends[0], &result.answer, sizeof(result.answer)) ==
             static_cast<ssize_t>(sizeof(result.answer)))
    {
        result.ending = Ending::Answered;
    }
    close(ends[0]);
    waitpid(child, nullptr, 0);
    result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}
}  // namespace bullet_ccd::tests
