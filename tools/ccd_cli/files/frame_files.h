/// Frames of a mesh that deforms: OBJ files with the same faces and moving vertices.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// A frame as its file has it: unlike loadMeshFile(), no vertex is merged or removed, so that the
/// vertices of all frames correspond.
struct FrameFile
{
    std::filesystem::path path;
    PolygonSoup soup;

    /// True if both have the same number of vertices and the same faces.
    [[nodiscard]] bool hasTopologyOf(const FrameFile& other) const;
    /// The faces as triangles. Throws std::runtime_error "<path>: <what>: <remedy>".
    [[nodiscard]] TriangleMesh triangles() const;
};

/// Reads an OBJ file. Throws std::runtime_error "<path>: <what, where>: <remedy>", also for a file
/// of another format and one without faces.
[[nodiscard]] FrameFile readFrame(const std::filesystem::path& path);

/// Throws std::runtime_error that names both files and the first difference, unless they have the
/// same topology.
void requireSameTopology(const FrameFile& start, const FrameFile& end);

/// The files of a folder whose names match, with one * for any characters, for example
/// frames/cloth_*.obj, in the order of the numbers in their names.
/// Throws std::runtime_error "<pattern>: <what>: <remedy>" if there are fewer than two.
[[nodiscard]] std::vector<std::filesystem::path> framesOf(const std::string& pattern);

/// For each vertex of a mesh the number of the connected part that it belongs to; parts are
/// numbered in the order of their first vertices. kNone for vertices of no triangle.
[[nodiscard]] std::vector<std::int32_t> connectedParts(const TriangleMesh& mesh);
}  // namespace bullet_ccd::tools
