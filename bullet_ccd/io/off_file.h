/// OFF, the text format of Geomview: with or without normals, colours and texture coordinates at
/// its vertices, and colours at its faces, all of which are skipped.
///
/// Read by own code because assimp reads a vertex from a line: what stands on two lines, or beside
/// another one, or behind a comment, is refused or comes out wrong.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <filesystem>

namespace bullet_ccd
{
/// White space of any kind and comments (`#` to the end of the line) may stand anywhere. Numbers
/// become the nearest double. Throws std::runtime_error: "<path>: line <n>: <what>: <remedy>".
[[nodiscard]] PolygonSoup readOff(const std::filesystem::path& path);
}  // namespace bullet_ccd
