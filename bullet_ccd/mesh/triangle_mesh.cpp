#include "bullet_ccd/mesh/triangle_mesh.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/LU>

#include <algorithm>
#include <bit>
#include <numeric>
#include <tuple>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// Below this share of the cubed diagonal a volume is rounding noise of a flat mesh.
constexpr double kFlatVolume = 1e-12;

const Eigen::Vector3d& corner(const TriangleMesh& mesh, const Triangle& triangle, std::size_t i)
{
    return mesh.vertices[static_cast<std::size_t>(triangle[i])];
}

bool hasEqualCorners(const Triangle& t)
{
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

bool hasZeroArea(const TriangleMesh& mesh, const Triangle& t)
{
    const Eigen::Vector3d& a = corner(mesh, t, 0);
    return (corner(mesh, t, 1) - a).cross(corner(mesh, t, 2) - a).isZero(0.0);
}

std::string formatVector(const Eigen::Vector3d& v)
{
    return "(" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " +
           std::to_string(v.z()) + ")";
}

/// Redirects all corners to the first of exactly equal vertices.
std::int64_t mergeEqualVertices(TriangleMesh& mesh)
{
    std::vector<std::int32_t> order(mesh.vertices.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](std::int32_t i)
    {
        const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(i)];
        return std::tuple(v.x(), v.y(), v.z());
    };
    std::ranges::sort(order,
                      [&](std::int32_t i, std::int32_t j)
                      { return std::tuple(key(i), i) < std::tuple(key(j), j); });
    std::vector<std::int32_t> first(mesh.vertices.size());
    std::int64_t merged = 0;
    for (std::size_t k = 0; k < order.size(); ++k)
    {
        const bool equal = k > 0 && key(order[k - 1]) == key(order[k]);
        first[static_cast<std::size_t>(order[k])] =
            equal ? first[static_cast<std::size_t>(order[k - 1])] : order[k];
        merged += equal ? 1 : 0;
    }
    for (Triangle& triangle : mesh.triangles)
    {
        for (std::int32_t& index : triangle)
        {
            index = first[static_cast<std::size_t>(index)];
        }
    }
    return merged;
}

std::int64_t removeDuplicateTriangles(TriangleMesh& mesh)
{
    std::vector<std::pair<Triangle, std::size_t>> keyed;
    keyed.reserve(mesh.triangles.size());
    for (Triangle key : mesh.triangles)
    {
        std::ranges::sort(key);
        keyed.emplace_back(key, keyed.size());
    }
    std::ranges::sort(keyed);
    std::vector<bool> duplicate(keyed.size(), false);
    for (std::size_t k = 1; k < keyed.size(); ++k)
    {
        duplicate[keyed[k].second] = keyed[k].first == keyed[k - 1].first;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < duplicate.size(); ++i)
    {
        if (!duplicate[i])
        {
            mesh.triangles[kept++] = mesh.triangles[i];
        }
    }
    mesh.triangles.resize(kept);
    return static_cast<std::int64_t>(duplicate.size() - kept);
}

/// Renumbers the vertices in use, keeping their order.
void dropUnreferencedVertices(TriangleMesh& mesh)
{
    std::vector<std::int32_t> renumbered(mesh.vertices.size(), kNone);
    for (const Triangle& triangle : mesh.triangles)
    {
        for (const std::int32_t index : triangle)
        {
            renumbered[static_cast<std::size_t>(index)] = 0;
        }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < renumbered.size(); ++i)
    {
        if (renumbered[i] != kNone)
        {
            renumbered[i] = static_cast<std::int32_t>(kept);
            mesh.vertices[kept++] = mesh.vertices[i];
        }
    }
    mesh.vertices.resize(kept);
    for (Triangle& triangle : mesh.triangles)
    {
        for (std::int32_t& index : triangle)
        {
            index = renumbered[static_cast<std::size_t>(index)];
        }
    }
}

MassProperties boxMassProperties(const Eigen::AlignedBox3d& box)
{
    MassProperties result;
    if (box.isEmpty())
    {
        return result;
    }
    const Eigen::Vector3d size = box.sizes();
    const Eigen::Vector3d squared = size.cwiseAbs2();
    result.volume = size.prod();
    result.center = box.center();
    result.inertia =
        (result.volume / 12.0) *
        (Eigen::Vector3d::Constant(squared.sum()) - squared).asDiagonal().toDenseMatrix();
    return result;
}

std::string counted(std::int64_t count, const std::string& one, const std::string& many)
{
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

class Fnv1a
{
public:
    void add(std::uint64_t value)
    {
        for (int byte = 0; byte < 8; ++byte)
        {
            m_hash = (m_hash ^ ((value >> (8 * byte)) & 0xffU)) * 0x100000001b3U;
        }
    }
    [[nodiscard]] std::uint64_t hash() const { return m_hash; }

private:
    std::uint64_t m_hash = 0xcbf29ce484222325U;
};
}  // namespace

std::string MeshRepair::summary() const
{
    std::string merged;
    if (mergedVertices > 0)
    {
        merged = "merged " + counted(mergedVertices, "equal vertex", "equal vertices");
    }
    std::string removed;
    const auto addRemoved = [&](std::int64_t count, const std::string& one, const std::string& many)
    {
        if (count > 0)
        {
            removed += (removed.empty() ? "removed " : ", ") + counted(count, one, many);
        }
    };
    addRemoved(degenerateTriangles, "degenerate triangle", "degenerate triangles");
    addRemoved(duplicateTriangles, "duplicate triangle", "duplicate triangles");
    addRemoved(unreferencedVertices, "unreferenced vertex", "unreferenced vertices");
    return merged + (merged.empty() || removed.empty() ? "" : ", ") + removed;
}

void checkMesh(const TriangleMesh& mesh, const std::string& name)
{
    require(!mesh.triangles.empty(),
            name + ": mesh has no triangles (" + std::to_string(mesh.vertices.size()) +
                " vertices): export it with its faces");
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    {
        if (!mesh.vertices[i].allFinite())
        {
            throw std::invalid_argument(name + ": vertex " + std::to_string(i) + " is " +
                                        formatVector(mesh.vertices[i]) +
                                        ": coordinates must be finite; export the mesh again");
        }
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        for (const std::int32_t index : mesh.triangles[i])
        {
            if (index < 0 || static_cast<std::size_t>(index) >= mesh.vertices.size())
            {
                throw std::invalid_argument(
                    name + ": triangle " + std::to_string(i) + " refers to vertex " +
                    std::to_string(index) + ": the mesh has " +
                    std::to_string(mesh.vertices.size()) +
                    " vertices, counted from 0; correct the index or add the vertex");
            }
        }
    }
}

MeshRepair repairMesh(TriangleMesh& mesh)
{
    MeshRepair repair;
    const std::size_t verticesBefore = mesh.vertices.size();
    repair.mergedVertices = mergeEqualVertices(mesh);
    repair.degenerateTriangles =
        static_cast<std::int64_t>(std::erase_if(mesh.triangles, hasEqualCorners));
    repair.duplicateTriangles = removeDuplicateTriangles(mesh);
    if (!isWatertight(mesh))
    {
        repair.degenerateTriangles += static_cast<std::int64_t>(
            std::erase_if(mesh.triangles, [&](const Triangle& t) { return hasZeroArea(mesh, t); }));
    }
    dropUnreferencedVertices(mesh);
    repair.unreferencedVertices =
        static_cast<std::int64_t>(verticesBefore - mesh.vertices.size()) - repair.mergedVertices;
    return repair;
}

bool isWatertight(const TriangleMesh& mesh)
{
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t i = 0; i < 3; ++i)
        {
            edges.emplace_back(t[i], t[(i + 1) % 3]);
        }
    }
    std::ranges::sort(edges);
    if (edges.empty() || std::ranges::adjacent_find(edges) != edges.end())
    {
        return false;
    }
    return std::ranges::all_of(
        edges,
        [&](const auto& edge)
        { return std::ranges::binary_search(edges, std::pair(edge.second, edge.first)); });
}

MassProperties massProperties(const TriangleMesh& mesh)
{
    const Eigen::AlignedBox3d box = bounds(mesh);
    if (!isWatertight(mesh))
    {
        return boxMassProperties(box);
    }
    // Tetrahedra from the centre of the bounds: from a far origin their volumes would cancel.
    const Eigen::Vector3d origin = box.center();
    double volume = 0.0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Triangle& t : mesh.triangles)
    {
        const Eigen::Vector3d a = corner(mesh, t, 0) - origin;
        const Eigen::Vector3d b = corner(mesh, t, 1) - origin;
        const Eigen::Vector3d c = corner(mesh, t, 2) - origin;
        const Eigen::Vector3d sum = a + b + c;
        const double determinant = a.dot(b.cross(c));
        volume += determinant / 6.0;
        first += (determinant / 24.0) * sum;
        second += (determinant / 120.0) * (a * a.transpose() + b * b.transpose() +
                                           c * c.transpose() + sum * sum.transpose());
    }
    const double diagonal = box.diagonal().norm();
    if (!(volume > kFlatVolume * diagonal * diagonal * diagonal))
    {
        return boxMassProperties(box);
    }
    const Eigen::Vector3d center = first / volume;
    const Eigen::Matrix3d central = second - volume * center * center.transpose();
    MassProperties result;
    result.volume = volume;
    result.center = origin + center;
    result.inertia = central.trace() * Eigen::Matrix3d::Identity() - central;
    return result;
}

Eigen::AlignedBox3d bounds(const TriangleMesh& mesh)
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        box.extend(vertex);
    }
    return box;
}

void transformMesh(TriangleMesh& mesh, const Eigen::Affine3d& transform)
{
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex = transform * vertex;
    }
    if (transform.linear().determinant() < 0.0)
    {
        for (Triangle& triangle : mesh.triangles)
        {
            std::swap(triangle[1], triangle[2]);
        }
    }
}

void appendMesh(TriangleMesh& mesh, const TriangleMesh& other)
{
    const auto offset = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    mesh.triangles.reserve(mesh.triangles.size() + other.triangles.size());
    for (const Triangle& t : other.triangles)
    {
        mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    }
}

std::uint64_t contentHash(const TriangleMesh& mesh)
{
    Fnv1a hash;
    hash.add(mesh.vertices.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        for (const double coordinate : vertex)
        {
            hash.add(std::bit_cast<std::uint64_t>(coordinate));
        }
    }
    for (const Triangle& triangle : mesh.triangles)
    {
        for (const std::int32_t index : triangle)
        {
            hash.add(static_cast<std::uint64_t>(index));
        }
    }
    return hash.hash();
}
}  // namespace bullet_ccd
