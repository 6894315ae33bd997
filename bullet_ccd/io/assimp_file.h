/// STL, PLY, OFF, DAE, glTF and GLB by assimp, guarded against broken files.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <filesystem>

namespace bullet_ccd
{
/// All meshes of all nodes, node transforms applied.
/// Throws std::runtime_error: "<path>: <what>: <remedy>".
[[nodiscard]] PolygonSoup readWithAssimp(const std::filesystem::path& path);
}  // namespace bullet_ccd
