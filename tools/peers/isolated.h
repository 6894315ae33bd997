/// Runs code that may crash or never return in a process of its own.
#pragma once

#include "tools/peers/peer.h"

#include <functional>

namespace bullet_ccd::tests
{
enum class Ending
{
    Answered,
    Crashed,
    TimedOut,
};

struct IsolatedAnswer
{
    Ending ending = Ending::Crashed;
    PeerAnswer answer = {};
    double seconds = 0.0;
};

/// Output of the code is dropped. Throws std::runtime_error if no process can be started.
[[nodiscard]] IsolatedAnswer runIsolated(const std::function<PeerAnswer()>& code, double limit);
}  // namespace bullet_ccd::tests
