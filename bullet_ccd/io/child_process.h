/// Work that may crash or hang, done where it does no harm.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace bullet_ccd
{
/// Runs `task` in a child process and returns what it returned, which must not be empty.
///
/// The child may use 2 s of processor time and 2 GiB of memory, and 2 s and 64 MiB more for every
/// MiB of `inputBytes`. Throws std::runtime_error starting with `name` if it crashes, needs more,
/// does not end for ten minutes or cannot be started. `task` must not throw. POSIX.
[[nodiscard]] std::string runInChild(const std::function<std::string()>& task,
                                     std::size_t inputBytes,
                                     const std::string& name);
}  // namespace bullet_ccd
