/// The command line that soak programs share.
#pragma once

#include "benchmarks/soak/soak_subject.h"

namespace bullet_ccd::tests
{
/// Runs the range of seeds that the arguments ask for and prints a table of the answers by family.
/// Returns the exit code: 1 on any wrong answer, 2 if the run proves little, 3 if it could not be
/// run; the code of CLI11 for arguments that it refuses.
[[nodiscard]] int soakProgram(const SoakSubject& subject, int argc, char** argv);
}  // namespace bullet_ccd::tests
