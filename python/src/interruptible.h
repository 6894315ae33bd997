/// Long work that Ctrl-C ends.
#pragma once

#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/toi/toi.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <optional>
#include <pybind11/pybind11.h>
#include <type_traits>
#include <utility>

namespace bullet_ccd::python
{
/// Runs work(stop) on a thread of its own, without Python's lock. Every 20 ms Python's signal
/// handlers get their turn; if one of them raises (KeyboardInterrupt), `stop` becomes true.
///
/// Returns false if that happened; Python's error is set then, for the caller to raise when it has
/// kept what was done. What work throws is thrown here.
template <class Work>
[[nodiscard]] bool interruptible(const Work& work)
{
    std::atomic<bool> stop = false;
    std::future<void> done = std::async(std::launch::async, [&] { work(stop); });
    while (true)
    {
        {
            const pybind11::gil_scoped_release release;
            if (done.wait_for(std::chrono::milliseconds(20)) == std::future_status::ready)
            {
                break;
            }
        }
        if (PyErr_CheckSignals() != 0)
        {
            stop = true;
            const pybind11::gil_scoped_release release;
            done.wait();
            break;
        }
    }
    if (PyErr_Occurred() != nullptr)
    {
        return false;
    }
    done.get();
    return true;
}

/// The same for work of which nothing is kept if Ctrl-C ends it: throws what Python's handlers
/// raised.
template <class Work>
void runInterruptibly(const Work& work)
{
    if (!interruptible(work))
    {
        throw pybind11::error_already_set();
    }
}

/// A query that is short as a rule. It is asked on this thread, which costs nothing; if it takes
/// longer than a moment, it begins again on a thread of its own, where Ctrl-C ends it.
/// @param ask ask(StopCondition) returns the answer, which says by its status or by isComplete
///            whether the condition ended it
template <class Ask>
[[nodiscard]] auto askInterruptibly(const StopCondition& limit, const Ask& ask)
{
    constexpr std::chrono::milliseconds kMoment(20);
    const auto askHere = [&]
    {
        const pybind11::gil_scoped_release release;
        return ask({.deadline = std::min(limit.deadline, StopCondition::Clock::now() + kMoment)});
    };
    auto answer = askHere();
    bool isStopped = false;
    if constexpr (requires { answer.isComplete; })
    {
        isStopped = !answer.isComplete;
    }
    else
    {
        isStopped = answer.status == ToiStatus::Stopped;
    }
    if (isStopped && !limit.isDue())
    {
        runInterruptibly([&](const std::atomic<bool>& stop)
                         { answer = ask({.deadline = limit.deadline, .isCancelled = &stop}); });
    }
    return answer;
}

/// The same for a query that throws QueryStopped. Throws Python's TimeoutError when the time is
/// over: there is no answer then.
/// @param timeLimit [s]
template <class Ask>
[[nodiscard]] auto answerWithin(double timeLimit, const Ask& ask)
{
    struct Answer
    {
        std::optional<std::invoke_result_t<Ask, StopCondition>> value;
        bool isComplete = false;
    };
    Answer answer = askInterruptibly(stopAfter(timeLimit),
                                     [&](const StopCondition& stop) -> Answer
                                     {
                                         try
                                         {
                                             return {.value = ask(stop), .isComplete = true};
                                         }
                                         catch (const QueryStopped&)
                                         {
                                             return {};
                                         }
                                     });
    if (!answer.isComplete)
    {
        PyErr_SetString(PyExc_TimeoutError, "the time limit ended the call before its answer");
        throw pybind11::error_already_set();
    }
    return std::move(*answer.value);
}
}  // namespace bullet_ccd::python
