#include "tools/support/obstacles/scene_manifest.h"

#include "bullet_ccd/io/mesh_file.h"
#include "tools/support/csv_text.h"

#include <array>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

/// FNV-1a over 64-bit words of the file.
std::uint64_t fileHash(const fs::path& path)
{
    std::ifstream file(path, std::ios::binary);
    std::uint64_t hash = 0xcbf29ce484222325U;
    std::array<std::uint64_t, 8192> words{};
    while (file)
    {
        words.fill(0);
        file.read(reinterpret_cast<char*>(words.data()), sizeof(words));
        const auto bytes = static_cast<std::size_t>(file.gcount());
        for (std::size_t k = 0; k < (bytes + 7) / 8; ++k)
        {
            hash = (hash ^ words[k]) * 0x100000001b3U;
            hash ^= hash >> 32U;
        }
    }
    return hash;
}

std::uint64_t fileBytes(const fs::path& path)
{
    std::error_code error;
    const std::uint64_t bytes = fs::file_size(path, error);
    if (error)
    {
        throw std::runtime_error(path.string() +
                                 ": cannot be read: check the path and its permissions");
    }
    return bytes;
}
}  // namespace

MeshFacts meshFactsOf(const fs::path& mesh, double scale)
{
    const TriangleMesh loaded = loadMeshFile(mesh, {.scale = scale}).mesh;
    return {.box = bounds(loaded),
            .triangles = loaded.triangles.size(),
            .bytes = fileBytes(mesh),
            .hash = fileHash(mesh)};
}

std::string manifestText(const fs::path& scene,
                         const fs::path& folder,
                         const std::function<void(std::size_t, std::size_t)>& progress)
{
    const fs::path base =
        (folder.empty() ? fs::current_path() : fs::absolute(folder)).lexically_normal();
    const std::vector<PlacedMesh> placed = readScene(scene);
    std::map<std::pair<std::string, double>, MeshFacts> known;
    std::string text =
        "mesh,name,scale,qw,qx,qy,qz,tx,ty,tz,triangles,low_x,low_y,low_z,high_x,high_y,high_z,"
        "bytes,hash\n";
    for (std::size_t k = 0; k < placed.size(); ++k)
    {
        const PlacedMesh& mesh = placed[k];
        if (mesh.box)
        {
            throw std::runtime_error(mesh.where +
                                     "a manifest lists files, and this has none: write its mesh");
        }
        const std::pair key(mesh.mesh.string(), mesh.scale);
        if (!known.contains(key))
        {
            try
            {
                known[key] = meshFactsOf(mesh.mesh, mesh.scale);
            }
            catch (const std::runtime_error& error)
            {
                throw std::runtime_error(mesh.where + error.what());
            }
        }
        const MeshFacts& facts = known[key];
        const Eigen::Quaterniond q(mesh.X_WO.linear());
        const Eigen::Vector3d& p = mesh.X_WO.translation();
        const Eigen::Vector3d& low = facts.box.min();
        const Eigen::Vector3d& high = facts.box.max();
        const fs::path file = fs::absolute(mesh.mesh).lexically_normal().lexically_relative(base);
        text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:016x}\n",
                            csvCell(file.string()),
                            csvCell(mesh.name),
                            mesh.scale,
                            q.w(),
                            q.x(),
                            q.y(),
                            q.z(),
                            p.x(),
                            p.y(),
                            p.z(),
                            facts.triangles,
                            low.x(),
                            low.y(),
                            low.z(),
                            high.x(),
                            high.y(),
                            high.z(),
                            facts.bytes,
                            facts.hash);
        progress(k + 1, placed.size());
    }
    return text;
}

void checkFacts(const PlacedMesh& placed, const fs::path& manifest, bool looksAtContent)
{
    const auto changed = [&]
    {
        throw std::runtime_error(placed.where + placed.mesh.string() +
                                 ": is not what it was when the manifest was made: make it again "
                                 "by bullet-ccd manifest");
    };
    std::uint64_t bytes = 0;
    try
    {
        bytes = fileBytes(placed.mesh);
    }
    catch (const std::runtime_error& error)
    {
        throw std::runtime_error(placed.where + error.what());
    }
    std::error_code error;
    const bool isNewer =
        fs::last_write_time(placed.mesh, error) > fs::last_write_time(manifest, error);
    if (bytes != placed.facts->bytes ||
        ((looksAtContent || isNewer) && fileHash(placed.mesh) != placed.facts->hash))
    {
        changed();
    }
}
}  // namespace bullet_ccd::tools
