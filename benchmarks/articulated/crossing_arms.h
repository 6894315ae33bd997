/// Two arms with hands that cross each other.
#pragma once

#include "benchmarks/articulated/linkage_run.h"

namespace bullet_ccd::benchmarks
{
/// Prints a row. Returns whether all answers are right. Throws std::runtime_error for files that
/// are missing.
[[nodiscard]] bool runCrossingArms(const LinkageOptions& options);
}  // namespace bullet_ccd::benchmarks
