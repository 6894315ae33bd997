#include "benchmarks/support/limited_run.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <poll.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Child: answers from `first` on, as raw bytes into the pipe.
[[noreturn]] void answerAll(std::size_t first,
                            std::size_t count,
                            int pipe,
                            const std::function<ChartAnswer(std::size_t)>& call)
{
    for (std::size_t i = first; i < count; ++i)
    {
        const ChartAnswer answer = call(i);
        if (write(pipe, &answer, sizeof answer) != static_cast<ssize_t>(sizeof answer))
        {
            _exit(1);
        }
    }
    _exit(0);
}

/// Waits for one answer; false at the limit or if the child has died.
bool readAnswer(int pipe, double seconds, ChartAnswer& answer)
{
    pollfd wait{.fd = pipe, .events = POLLIN, .revents = 0};
    int ready = 0;
    do
    {
        ready = poll(&wait, 1, static_cast<int>(seconds * 1e3));
    } while (ready < 0 && errno == EINTR);
    // An answer is far below PIPE_BUF: it comes whole.
    return ready > 0 && read(pipe, &answer, sizeof answer) == static_cast<ssize_t>(sizeof answer);
}
}  // namespace

std::vector<ChartAnswer> runWithLimit(std::size_t count,
                                      double secondsEach,
                                      const std::function<ChartAnswer(std::size_t)>& call)
{
    std::vector<ChartAnswer> answers;
    while (answers.size() < count)
    {
        std::array<int, 2> ends{};
        if (pipe(ends.data()) != 0)
        {
            throw std::runtime_error("chart: no pipe: close other programs");
        }
        const pid_t child = fork();
        if (child < 0)
        {
            throw std::runtime_error("chart: no child process: close other programs");
        }
        if (child == 0)
        {
            close(ends[0]);
            answerAll(answers.size(), count, ends[1], call);
        }
        close(ends[1]);
        ChartAnswer answer;
        while (answers.size() < count && readAnswer(ends[0], secondsEach, answer))
        {
            answers.push_back(answer);
        }
        if (answers.size() < count)
        {
            answers.push_back({.micros = secondsEach * 1e6, .timedOut = true});
        }
        kill(child, SIGKILL);
        waitpid(child, nullptr, 0);
        close(ends[0]);
    }
    return answers;
}
}  // namespace bullet_ccd::benchmarks
