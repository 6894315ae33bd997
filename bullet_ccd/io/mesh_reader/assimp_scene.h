/// A scene as assimp reads it, as polygons.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <string>

namespace bullet_ccd
{
/// All meshes of all nodes, node transforms applied. Limits what this process may use: see
/// ReaderLimits.
/// Throws std::runtime_error "<name>: <what>: <remedy>", or std::bad_alloc at the limit of memory;
/// a broken file may also end the process, and so does the limit of time.
[[nodiscard]] PolygonSoup readScene(const std::string& name, int seconds, int mebibytes);
}  // namespace bullet_ccd
