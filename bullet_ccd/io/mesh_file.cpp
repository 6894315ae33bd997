#include "bullet_ccd/io/mesh_file.h"

#include "bullet_ccd/io/obj_file.h"
#include "bullet_ccd/io/off_file.h"
#include "bullet_ccd/io/plain_obj.h"
#include "bullet_ccd/io/polygon_soup.h"
#include "bullet_ccd/io/reader_process.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace bullet_ccd
{
namespace
{
constexpr std::array<std::string_view, 7> kExtensions = {
    ".obj", ".stl", ".ply", ".off", ".dae", ".gltf", ".glb"};

std::string lowerExtension(const std::filesystem::path& path)
{
    std::string extension = path.extension().string();
    std::transform(extension.begin(),
                   extension.end(),
                   extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

void requireReadable(const std::filesystem::path& path, const std::string& extension)
{
    std::error_code error;
    if (!std::filesystem::exists(path, error))
    {
        throw std::runtime_error(path.string() + ": no such file: check the path");
    }
    if (!std::filesystem::is_regular_file(path, error))
    {
        throw std::runtime_error(path.string() + ": not a file: name a mesh file");
    }
    if (std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end())
    {
        throw std::runtime_error(path.string() + ": extension '" + extension +
                                 "': convert it to OBJ, STL, PLY, OFF, DAE, glTF or GLB");
    }
    if (std::filesystem::file_size(path, error) == 0)
    {
        throw std::runtime_error(path.string() + ": the file is empty: export the mesh again");
    }
}

/// checkMesh() reports a wrong argument; here the argument came from a file.
void checkFileMesh(const TriangleMesh& mesh, const std::string& name)
{
    try
    {
        checkMesh(mesh, name);
    }
    catch (const std::invalid_argument& error)
    {
        throw std::runtime_error(error.what());
    }
}

std::string extentNote(const TriangleMesh& mesh, double scale)
{
    const Eigen::Vector3d extent = bounds(mesh).sizes();
    if (extent.maxCoeff() <= kSuspiciousExtent)
    {
        return {};
    }
    char text[200];
    std::snprintf(
        text,
        sizeof(text),
        "extent %.4g x %.4g x %.4g m: if the file is in millimetres, load it with scale %g",
        extent.x(),
        extent.y(),
        extent.z(),
        0.001 * scale);
    return text;
}

PolygonSoup readSoup(const std::filesystem::path& path, const std::string& extension)
{
    if (extension == ".obj")
    {
        return readObj(path);
    }
    return extension == ".off" ? readOff(path) : readInProcess(path);
}

PlainObj readTriangles(const std::filesystem::path& path, const std::string& extension)
{
    if (extension == ".obj")
    {
        if (std::optional<PlainObj> plain = readPlainObj(path))
        {
            return *std::move(plain);
        }
    }
    PolygonSoup soup = readSoup(path, extension);
    const std::int64_t dropped = soup.droppedElements;
    return {.mesh = triangulate(std::move(soup), path.string()), .droppedElements = dropped};
}
}  // namespace

MeshFile loadMeshFile(const std::filesystem::path& path, const MeshFileOptions& options)
{
    const std::string name = path.string();
    if (!(options.scale > 0.0) || !std::isfinite(options.scale))
    {
        throw std::runtime_error(name + ": scale " + std::to_string(options.scale) +
                                 ": use a finite number > 0 such as 0.001");
    }
    const std::string extension = lowerExtension(path);
    requireReadable(path, extension);

    PlainObj read = readTriangles(path, extension);
    MeshFile file;
    file.mesh = std::move(read.mesh);
    if (read.droppedElements > 0)
    {
        file.notes.push_back("ignored " + std::to_string(read.droppedElements) +
                             " lines and points");
    }
    if (file.mesh.triangles.empty())
    {
        throw std::runtime_error(name + ": no faces among " +
                                 std::to_string(file.mesh.vertices.size()) +
                                 " vertices: export the surface, not a point cloud or a scene "
                                 "without meshes");
    }
    if (options.scale != 1.0)
    {
        for (Eigen::Vector3d& vertex : file.mesh.vertices)
        {
            vertex *= options.scale;
        }
    }
    checkFileMesh(file.mesh, name);
    file.repair = repairMesh(file.mesh);
    if (file.mesh.triangles.empty())
    {
        throw std::runtime_error(name + ": all triangles have zero area: export the mesh again");
    }
    // Merging is what every format without shared vertices needs; only the rest is news.
    MeshRepair news = file.repair;
    news.mergedVertices = 0;
    news.unreferencedVertices = 0;
    if (!news.summary().empty())
    {
        file.notes.push_back(file.repair.summary());
    }
    if (const std::string note = extentNote(file.mesh, options.scale); !note.empty())
    {
        file.notes.push_back(note);
    }
    return file;
}
}  // namespace bullet_ccd
