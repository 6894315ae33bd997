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
using Codes = std::span<const std::function<PeerAnswer()>>;

[[noreturn]] void answerInto(int pipe, Codes codes)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    try
    {
        for (const std::function<PeerAnswer()>& code : codes)
        {
            const auto start = std::chrono::steady_clock::now();
            PeerAnswer answer = code();
            answer.seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            if (write(pipe, &answer, sizeof(answer)) != static_cast<ssize_t>(sizeof(answer)))
            {
                _exit(EXIT_FAILURE);
            }
        }
        _exit(EXIT_SUCCESS);
    }
    catch (...)
    {
        _exit(EXIT_FAILURE);
    }
}

/// Answers of a child up to the first that ends it, which is told, too.
void runChild(Codes codes, double limit, std::vector<IsolatedAnswer>& answers)
{
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0)
    {
        throw std::runtime_error("no pipe to a child process: too many open files?");
    }
    const pid_t child = fork();
    if (child < 0)
    {
        throw std::runtime_error("no child process can be started: too many processes?");
    }
    if (child == 0)
    {
        close(ends[0]);
        answerInto(ends[1], codes);
    }
    close(ends[1]);
    for (std::size_t i = 0; i < codes.size(); ++i)
    {
        IsolatedAnswer result;
        pollfd waiting{.fd = ends[0], .events = POLLIN, .revents = 0};
        if (poll(&waiting, 1, static_cast<int>(1000.0 * limit)) == 0)
        {
            kill(child, SIGKILL);
            result.ending = Ending::TimedOut;
            result.answer.seconds = limit;
        }
        else if (read(ends[0], &result.answer, sizeof(result.answer)) ==
                 static_cast<ssize_t>(sizeof(result.answer)))
        {
            result.ending = Ending::Answered;
        }
        answers.push_back(result);
        if (result.ending != Ending::Answered)
        {
            break;
        }
    }
    close(ends[0]);
    waitpid(child, nullptr, 0);
}
}  // namespace

std::vector<IsolatedAnswer> runIsolated(Codes codes, double limit, int patience)
{
    std::vector<IsolatedAnswer> answers;
    int timedOut = 0;
    while (answers.size() < codes.size() && timedOut < patience)
    {
        runChild(codes.subspan(answers.size()), limit, answers);
        timedOut += answers.back().ending == Ending::TimedOut ? 1 : 0;
    }
    return answers;
}
}  // namespace bullet_ccd::tests
