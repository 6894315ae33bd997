/// Runs code that may crash or never return in a process of its own.
#pragma once

#include "benchmarks/stability/catalogue_peer.h"

#include <functional>
#include <span>
#include <vector>

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
};

/// One answer for each, with the seconds that it took. One child process runs them one after the
/// other; the one that ends it, or that takes more than `limit` seconds of processor time and is
/// ended, is followed by a new one for the rest, until `patience` of them took too long: there are
/// no answers to the rest then. Output of the code is dropped. Throws std::runtime_error if no
/// process can be started.
[[nodiscard]] std::vector<IsolatedAnswer> runIsolated(
    std::span<const std::function<PeerAnswer()>> codes, double limit, int patience);
}  // namespace bullet_ccd::tests
