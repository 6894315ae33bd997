/// STL, PLY, OFF, DAE, glTF and GLB by assimp.
///
/// Some broken files crash assimp's readers (wrong counts in a DAE, for instance) or keep them busy
/// for ever. They therefore run in a child process, which sends the mesh back through a pipe: what
/// goes wrong there is an exception here.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <filesystem>
#include <string>

namespace bullet_ccd
{
/// All meshes of all nodes, node transforms applied.
/// @param extension lower case, with dot
/// Throws std::runtime_error: "<path>: <what>: <remedy>".
[[nodiscard]] PolygonSoup readWithAssimp(const std::filesystem::path& path,
                                         const std::string& extension);
}  // namespace bullet_ccd
