#include "tools/support/obstacles/needed_picture.h"

#include "tools/support/text_file.h"

#include <array>
#include <bit>
#include <cstdint>
#include <fmt/format.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb kFine{230, 110, 20};
constexpr Rgb kCoarse{200, 205, 210};

template <class T>
void append(std::string& bytes, const T& value)
{
    static_assert(std::endian::native == std::endian::little);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

bool isFine(std::span<const ModelUse> uses, const SsvTree& tree, std::size_t triangle)
{
    for (const ModelUse& use : uses)
    {
        const std::span<const std::uint8_t> marks = use.marks(tree);
        if (!marks.empty() && marks[triangle] != 0)
        {
            return true;
        }
    }
    return false;
}
}  // namespace

void writeNeededPicture(const std::filesystem::path& path,
                        std::span<const ModelUse> uses,
                        std::span<const DrawnBody> bodies)
{
    std::string vertices;
    std::string faces;
    std::int32_t vertexCount = 0;
    std::size_t faceCount = 0;
    for (const DrawnBody& body : bodies)
    {
        if (body.tree == nullptr)
        {
            continue;
        }
        const TriangleMesh& mesh = body.tree->mesh();
        for (const Eigen::Vector3d& vertex : mesh.vertices)
        {
            const Eigen::Vector3f place = (body.X_WB * vertex).cast<float>();
            for (const float coordinate : place)
            {
                append(vertices, coordinate);
            }
        }
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        {
            append(faces, std::uint8_t{3});
            for (const std::int32_t corner : mesh.triangles[i])
            {
                append(faces, vertexCount + corner);
            }
            for (const std::uint8_t level : isFine(uses, *body.tree, i) ? kFine : kCoarse)
            {
                append(faces, level);
            }
        }
        vertexCount += static_cast<std::int32_t>(mesh.vertices.size());
        faceCount += mesh.triangles.size();
    }
    const std::string header = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment orange: looked at, grey: left to volumes\n"
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "element face {}\nproperty list uchar int vertex_indices\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        vertexCount,
        faceCount);
    writeWholeFile(path, header + vertices + faces);
}
}  // namespace bullet_ccd::tools
