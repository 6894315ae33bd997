#include "bullet_ccd/io/assimp_file.h"

#include "bullet_ccd/io/assimp_guard.h"
#include "bullet_ccd/io/child_process.h"

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd
{
namespace
{
Eigen::Affine3d toEigen(const aiMatrix4x4& m)
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
        const Eigen::Affine3d X = entry.X * toEigen(entry.node->mTransformation);
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
/// Never returns normally with half a scene: throws what is to be said to the user.
PolygonSoup readScene(const std::string& name)
{
    Assimp::Importer importer;
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    // No post-processing: assimp's steps trust indices, ours check them.
    const aiScene* const scene = importer.ReadFile(name, 0);
    if (scene == nullptr || scene->mRootNode == nullptr)
    {
        const std::string reason = importer.GetErrorString();
        throw std::runtime_error(name + ": " + (reason.empty() ? "not readable" : reason) +
                                 ": export the mesh again");
    }
    PolygonSoup soup;
    appendNodes(*scene, soup, name);
    return soup;
}

template <class Value>
void packArray(const std::vector<Value>& values, std::string& bytes)
{
    const std::uint64_t count = values.size();
    bytes.append(reinterpret_cast<const char*>(&count), sizeof(count));
    bytes.append(reinterpret_cast<const char*>(values.data()), count * sizeof(Value));
}

template <class Value>
void unpackArray(std::string_view& bytes, std::vector<Value>& values)
{
    std::uint64_t count = 0;
    std::memcpy(&count, bytes.data(), sizeof(count));
    bytes.remove_prefix(sizeof(count));
    values.resize(count);
    if (count > 0)
    {
        std::memcpy(static_cast<void*>(values.data()), bytes.data(), count * sizeof(Value));
    }
    bytes.remove_prefix(count * sizeof(Value));
}

constexpr char kMeshFollows = 'm';
constexpr char kErrorFollows = 'e';

/// What the child sends: a mesh or a message.
std::string readInChild(const std::string& name)
{
    try
    {
        const PolygonSoup soup = readScene(name);
        std::string bytes(1, kMeshFollows);
        packArray(soup.vertices, bytes);
        packArray(soup.corners, bytes);
        packArray(soup.polygonEnds, bytes);
        packArray(std::vector<std::int64_t>{soup.droppedElements}, bytes);
        return bytes;
    }
    catch (const std::exception& error)
    {
        const std::string what = error.what();
        return kErrorFollows +
               (what.rfind(name, 0) == 0 ? what : name + ": " + what + ": export the mesh again");
    }
}

PolygonSoup unpack(std::string_view bytes)
{
    const char kind = bytes.front();
    bytes.remove_prefix(1);
    if (kind != kMeshFollows)
    {
        throw std::runtime_error(std::string(bytes));
    }
    PolygonSoup soup;
    std::vector<std::int64_t> dropped;
    unpackArray(bytes, soup.vertices);
    unpackArray(bytes, soup.corners);
    unpackArray(bytes, soup.polygonEnds);
    unpackArray(bytes, dropped);
    soup.droppedElements = dropped.front();
    return soup;
}
}  // namespace

PolygonSoup readWithAssimp(const std::filesystem::path& path, const std::string& extension)
{
    const std::string name = path.string();
    std::ifstream file(path, std::ios::binary);
    const std::string content((std::istreambuf_iterator<char>(file)),
                              std::istreambuf_iterator<char>());
    if (!file)
    {
        throw std::runtime_error(name + ": cannot be read: check its permissions");
    }
    requirePlausible(content, extension, name);
    const std::string answer = runInChild([&] { return readInChild(name); }, content.size(), name);
    return unpack(answer);
}
}  // namespace bullet_ccd
