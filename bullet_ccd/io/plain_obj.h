/// The fast way through large OBJ files of triangles, as most programs write them.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cstdint>
#include <filesystem>
#include <optional>

namespace bullet_ccd
{
struct PlainObj
{
    TriangleMesh mesh;
    std::int64_t droppedElements = 0;  ///< lines and points
};

/// Reads a large OBJ file by all threads, a piece each, straight into a mesh.
///
/// Guarantee: what comes back is what readObj() and triangulate() make of the file, line by line.
/// Nothing comes back for small files and for all that is unusual: polygons of more corners,
/// relative indices, continued lines, signs before positive numbers, errors of any kind.
[[nodiscard]] std::optional<PlainObj> readPlainObj(const std::filesystem::path& path);
}  // namespace bullet_ccd
