/// The program `bullet-ccd`.
#pragma once

namespace bullet_ccd::tools
{
/// Returns the exit code.
[[nodiscard]] int runBulletCcd(int argc, char** argv);
}  // namespace bullet_ccd::tools
