/// Where what ships is found.
#pragma once

#include <filesystem>

namespace bullet_ccd::tools
{
/// Folder with robots/ and objects/: $BULLET_CCD_SHARE if set, else share/bullet_ccd beside the
/// folder of the program (the same in the build tree and where it is installed), else that of the
/// installation. Empty if none exists.
[[nodiscard]] std::filesystem::path shareFolder();
}  // namespace bullet_ccd::tools
