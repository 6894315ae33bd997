#include "bullet_ccd/io/mesh_reader/assimp_scene.h"

#include <Eigen/Geometry>
#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace bullet_ccd
{
namespace
{
Eigen::Affine3d affineOf(const aiMatrix4x4& m)
{
    Eigen::Affine3d transform;
    transform.matrix() << m.a1, m.a2, m.a3, m.a4,  //
        m.b1, m.b2, m.b3, m.b4,                    //
        m.c1, m.c2, m.c3, m.c4,                    //
        m.d1, m.d2, m.d3, m.d4;
    return transform;
}

/// Appends a mesh placed by `X`; a mirror image gets its corners in reverse order, so that what was
/// wound outwards still is.
void appendMesh(const aiMesh& mesh,
                const Eigen::Affine3d& X,
                PolygonSoup& soup,
                const std::string& name)
{
    constexpr std::size_t kMaxIndex = std::numeric_limits<std::int32_t>::max();
    const std::size_t offset = soup.vertices.size();
    if (offset + mesh.mNumVertices > kMaxIndex)
    {
        throw std::runtime_error(name + ": more than 2^31 vertices: split or simplify the mesh");
    }
    const bool mirrors = X.linear().determinant() < 0.0;
    soup.vertices.reserve(offset + mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    {
        const aiVector3D& v = mesh.mVertices[i];
        soup.vertices.push_back(X * Eigen::Vector3d(v.x, v.y, v.z));
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i)
    {
        const aiFace& face = mesh.mFaces[i];
        if (face.mNumIndices < 3)
        {
            ++soup.droppedElements;
            continue;
        }
        const std::size_t begin = soup.corners.size();
        for (unsigned k = 0; k < face.mNumIndices; ++k)
        {
            if (face.mIndices[k] >= mesh.mNumVertices)
            {
                throw std::runtime_error(name + ": face " + std::to_string(i) + ": vertex index " +
                                         std::to_string(face.mIndices[k]) + " is outside [0, " +
                                         std::to_string(mesh.mNumVertices) +
                                         "): export the mesh again");
            }
            soup.corners.push_back(static_cast<std::int32_t>(offset + face.mIndices[k]));
        }
        if (mirrors)
        {
            std::reverse(soup.corners.begin() + static_cast<std::ptrdiff_t>(begin),
                         soup.corners.end());
        }
        soup.polygonEnds.push_back(soup.corners.size());
    }
}

/// Depth-first over the node tree; an own stack, because files decide how deep it is.
void appendNodes(const aiScene& scene, PolygonSoup& soup, const std::string& name)
{
    struct Entry
    {
        const aiNode* node;
        Eigen::Affine3d X;  ///< of the parent
    };
    std::vector<Entry> stack{{scene.mRootNode, Eigen::Affine3d::Identity()}};
    while (!stack.empty())
    {
        const Entry entry = stack.back();
        stack.pop_back();
        const Eigen::Affine3d X = entry.X * affineOf(entry.node->mTransformation);
        for (unsigned i = 0; i < entry.node->mNumMeshes; ++i)
        {
            const unsigned index = entry.node->mMeshes[i];
            if (index >= scene.mNumMeshes || scene.mMeshes[index]->mVertices == nullptr)
            {
                throw std::runtime_error(name + ": a node refers to mesh " + std::to_string(index) +
                                         ", which has no data: export the mesh again");
            }
            appendMesh(*scene.mMeshes[index], X, soup, name);
        }
        for (unsigned i = entry.node->mNumChildren; i-- > 0;)
        {
            stack.push_back({entry.node->mChildren[i], X});
        }
    }
}

/// The files that a scene consists of; each one read for the first time allows for more.
class BudgetedFiles : public Assimp::DefaultIOSystem
{
public:
    BudgetedFiles(int seconds, int mebibytes)
        : m_seconds(static_cast<rlim_t>(seconds)), m_mebibytes(static_cast<rlim_t>(mebibytes))
    {
        // What is mapped already, code and libraries, is nobody's fault.
        rlim_t pages = 0;
        if (std::ifstream("/proc/self/statm") >> pages)
        {
            m_mapped = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
        }
        setLimits();
    }

    Assimp::IOStream* Open(const char* name, const char* mode) override
    {
        std::error_code error;
        const std::uintmax_t size = std::filesystem::file_size(name, error);
        if (!error && m_seen.insert(name).second)
        {
            m_bytes += size;
            setLimits();
        }
        return DefaultIOSystem::Open(name, mode);
    }

private:
    void setLimits() const
    {
        constexpr rlim_t kSecondsPerMiB = 2;
        constexpr rlim_t kMebibytesPerMiB = 64;
        constexpr rlim_t kMiB = 1U << 20U;
        const rlim_t input = m_bytes / kMiB;
        setLimit(RLIMIT_CPU, m_seconds + kSecondsPerMiB * input);
        setLimit(RLIMIT_AS, m_mapped + (m_mebibytes + kMebibytesPerMiB * input) * kMiB);
    }

    static void setLimit(decltype(RLIMIT_CPU) resource, rlim_t value)
    {
        rlimit limit{};
        if (::getrlimit(resource, &limit) == 0)
        {
            limit.rlim_cur = std::min(value, limit.rlim_max);
            static_cast<void>(::setrlimit(resource, &limit));
        }
    }

    rlim_t m_seconds;
    rlim_t m_mebibytes;
    rlim_t m_mapped = 0;
    rlim_t m_bytes = 0;
    std::set<std::string> m_seen;
};
}  // namespace

PolygonSoup readScene(const std::string& name, int seconds, int mebibytes)
{
    Assimp::Importer importer;
    importer.SetIOHandler(new BudgetedFiles(seconds, mebibytes));  // the importer's from now on
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    // No post-processing: assimp's steps trust indices, ours check them.
    const aiScene* const scene = importer.ReadFile(name, 0);
    if (scene == nullptr || scene->mRootNode == nullptr)
    {
        const std::string reason = importer.GetErrorString();
        if (reason.find("bad_alloc") != std::string::npos)
        {
            throw std::bad_alloc();
        }
        throw std::runtime_error(name + ": " + (reason.empty() ? "not readable" : reason) +
                                 ": export the mesh again");
    }
    PolygonSoup soup;
    appendNodes(*scene, soup, name);
    return soup;
}
}  // namespace bullet_ccd
