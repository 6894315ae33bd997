/// A check ahead of assimp, whose reader trusts the counts of a PLY header and allocates what no
/// file can hold.
#pragma once

#include <filesystem>

namespace bullet_ccd
{
/// Throws std::runtime_error: "<path>: <what, value>: <remedy>".
void requirePlausiblePly(const std::filesystem::path& path);
}  // namespace bullet_ccd
