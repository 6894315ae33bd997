#include "benchmarks/stability/catalogue_isolated.h"

#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::tests
{
namespace
{
using Codes = std::span<const std::function<PeerAnswer()>>;

/// Of this process.
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

[[noreturn]] void answerInto(int pipe, Codes codes, double limit)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    try
    {
        for (const std::function<PeerAnswer()>& code : codes)
        {
            endAfter(limit);
            const double start = processorSeconds();
            PeerAnswer answer = code();
            answer.seconds = processorSeconds() - start;
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
        answerInto(ends[1], codes, limit);
    }
    close(ends[1]);
    for (std::size_t i = 0; i < codes.size(); ++i)
    {
        IsolatedAnswer result;
        pollfd waiting{.fd = ends[0], .events = POLLIN, .revents = 0};
        // Processor time counts; this is for what sleeps for ever.
        if (poll(&waiting, 1, static_cast<int>(20'000.0 * limit)) == 0)
        {
            kill(child, SIGPROF);
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
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF &&
        answers.back().ending != Ending::Answered)
    {
        answers.back().ending = Ending::TimedOut;
        answers.back().answer.seconds = limit;
    }
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
