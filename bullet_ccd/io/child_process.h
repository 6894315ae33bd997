/// Work that may crash or hang, done where it does no harm.
#pragma once

#include <functional>
#include <string>

namespace bullet_ccd
{
/// Runs `work` in a child process and returns what it returned, which must not be empty.
/// Throws std::runtime_error starting with `name` if the child crashes, runs for more than a minute
/// or cannot be started. `work` must not throw. POSIX.
[[nodiscard]] std::string runInChild(const std::function<std::string()>& work,
                                     const std::string& name);
}  // namespace bullet_ccd
