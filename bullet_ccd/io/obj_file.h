/// Wavefront OBJ, the geometry of it: v, f, l and p lines; everything else is skipped.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/io/polygon_soup.h"

#include <filesystem>

namespace bullet_ccd
{
/// Reads vertices as nearest doubles and faces with absolute or relative (negative) indices.
/// Throws std::runtime_error: "<path>: line <n>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API PolygonSoup readObj(const std::filesystem::path& path);
}  // namespace bullet_ccd
