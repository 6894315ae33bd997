/// The program `grasp`.
#pragma once

namespace bullet_ccd::tools
{
/// Returns the exit code.
[[nodiscard]] int runGrasp(int argc, char** argv);
}  // namespace bullet_ccd::tools
