#include "bullet_ccd/mesh/triangle_mesh.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/LU>

#include <algorithm>
#include <bit>
#include <numeric>
#include <oneapi/tbb/parallel_for.h>
#include <ranges>
#include <span>
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

std::uint64_t mixed(std::uint64_t hash, std::uint64_t word)
{
    hash = (hash ^ word) * 0x9E3779B97F4A7C15U;
    return hash ^ (hash >> 32U);
}

/// Of each of `count` things the first that equals it, by a table with open addresses.
/// @param hashOf  of a thing by its index; equal for equal things
template <typename HashOf, typename AreEqual>
std::vector<std::int32_t> firstOfEqual(std::size_t count,
                                       const HashOf& hashOf,
                                       const AreEqual& areEqual)
{
    std::vector<std::int32_t> table(std::bit_ceil(2 * count + 1), kNone);
    const std::size_t mask = table.size() - 1;
    std::vector<std::int32_t> first(count);
    for (std::size_t i = 0; i < count; ++i)
    {
        std::size_t at = hashOf(i) & mask;
        while (table[at] != kNone && !areEqual(static_cast<std::size_t>(table[at]), i))
        {
            at = (at + 1) & mask;
        }
        table[at] = table[at] == kNone ? static_cast<std::int32_t>(i) : table[at];
        first[i] = table[at];
    }
    return first;
}

/// Of `count` things those that may equal another, in their order: all that do, and few that do
/// not. Most meshes have none, and this is much faster than a table.
template <typename HashOf>
std::vector<std::int32_t> thoseWithEqualHash(std::size_t count, const HashOf& hashOf)
{
    constexpr std::size_t kBits = 64;
    const std::size_t words = std::bit_ceil(count / 4 + 1);
    std::vector<std::uint64_t> once(words);
    std::vector<std::uint64_t> twice(words);
    const auto find = [&](std::size_t i)
    {
        const std::uint64_t hash = hashOf(i);
        return std::pair((hash / kBits) & (words - 1), std::uint64_t{1} << hash % kBits);
    };
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto [word, bit] = find(i);
        twice[word] |= once[word] & bit;
        once[word] |= bit;
    }
    std::vector<std::int32_t> found;
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto [word, bit] = find(i);
        if ((twice[word] & bit) != 0)
        {
            found.push_back(static_cast<std::int32_t>(i));
        }
    }
    return found;
}

/// What look(i, found) adds to `found` for some i below `count`, in the order of i, by all threads.
template <typename Found, typename Look>
std::vector<Found> collected(std::size_t count, const Look& look)
{
    constexpr std::size_t kChunk = 1U << 14;
    std::vector<std::vector<Found>> parts((count + kChunk - 1) / kChunk);
    const auto lookAt = [&](std::size_t part)
    {
        for (std::size_t i = part * kChunk; i < std::min(count, (part + 1) * kChunk); ++i)
        {
            look(i, parts[part]);
        }
    };
    if (parts.size() < 2)  // starting threads would cost more than the work
    {
        std::ranges::for_each(std::views::iota(std::size_t{0}, parts.size()), lookAt);
    }
    else
    {
        tbb::parallel_for(std::size_t{0}, parts.size(), lookAt);
    }
    std::vector<Found> all;
    for (const std::vector<Found>& part : parts)
    {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

/// Redirects all corners to the first of exactly equal vertices.
std::int64_t mergeEqualVertices(TriangleMesh& mesh)
{
    const std::vector<Eigen::Vector3d>& vertices = mesh.vertices;
    const auto hashOf = [&](std::size_t i)
    {
        std::uint64_t hash = 0;
        for (const double coordinate : vertices[i])
        {
            hash = mixed(hash, std::bit_cast<std::uint64_t>(coordinate + 0.0));  // -0 equals 0
        }
        return hash;
    };
    const std::vector<std::int32_t> some = thoseWithEqualHash(vertices.size(), hashOf);
    const auto in = [&](std::size_t i) { return static_cast<std::size_t>(some[i]); };
    const std::vector<std::int32_t> firstOfSome = firstOfEqual(
        some.size(),
        [&](std::size_t i) { return hashOf(in(i)); },
        [&](std::size_t i, std::size_t k) { return vertices[in(i)] == vertices[in(k)]; });
    std::vector<std::int32_t> first;
    std::int64_t merged = 0;
    for (std::size_t i = 0; i < some.size(); ++i)
    {
        if (static_cast<std::size_t>(firstOfSome[i]) != i)
        {
            if (merged++ == 0)
            {
                first.resize(vertices.size());
                std::iota(first.begin(), first.end(), 0);
            }
            first[in(i)] = some[static_cast<std::size_t>(firstOfSome[i])];
        }
    }
    if (merged == 0)
    {
        return 0;
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

std::int32_t leastOf(const Triangle& t)
{
    return std::min({t[0], t[1], t[2]});
}

/// Triangles of the same three vertices are equal, whatever their order. Those of the same least
/// vertex, which are few, are looked at together.
std::int64_t removeDuplicateTriangles(TriangleMesh& mesh)
{
    const std::size_t count = mesh.triangles.size();
    std::vector<std::int32_t> begin(mesh.vertices.size() + 1, 0);
    for (const Triangle& t : mesh.triangles)
    {
        ++begin[static_cast<std::size_t>(leastOf(t))];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::int32_t> byLeast(count);
    for (std::size_t i = count; i-- > 0;)
    {
        const auto at = --begin[static_cast<std::size_t>(leastOf(mesh.triangles[i]))];
        byLeast[static_cast<std::size_t>(at)] = static_cast<std::int32_t>(i);
    }
    // The other two vertices of a triangle, whatever their order.
    const auto keyOf = [&](std::int32_t i)
    {
        const Triangle& t = mesh.triangles[static_cast<std::size_t>(i)];
        const auto [least, most] = std::minmax({t[0], t[1], t[2]});
        const std::int64_t middle = std::int64_t{t[0]} + t[1] + t[2] - least - most;
        return (middle << 32U) + most;
    };
    std::vector<std::int32_t> duplicates = collected<std::int32_t>(
        mesh.vertices.size(),
        [&](std::size_t vertex, std::vector<std::int32_t>& found)
        {
            const auto group = std::span(byLeast).subspan(
                static_cast<std::size_t>(begin[vertex]),
                static_cast<std::size_t>(begin[vertex + 1] - begin[vertex]));
            constexpr std::size_t kFew = 8;
            if (group.size() > kFew)
            {
                std::ranges::stable_sort(group, {}, keyOf);
            }
            std::array<std::int64_t, kFew> keys{};
            for (std::size_t i = 0; i < group.size(); ++i)
            {
                const std::int64_t key = keyOf(group[i]);
                const std::size_t before = std::min(i, kFew);
                const auto known = std::span(keys).first(before);
                if (std::ranges::find(known, key) != known.end())
                {
                    found.push_back(group[i]);
                }
                keys[i % kFew] = key;
            }
        });
    if (duplicates.empty())
    {
        return 0;
    }
    std::ranges::sort(duplicates);
    auto next = duplicates.begin();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i)
    {
        if (next != duplicates.end() && static_cast<std::size_t>(*next) == i)
        {
            ++next;
            continue;
        }
        mesh.triangles[kept++] = mesh.triangles[i];
    }
    mesh.triangles.resize(kept);
    return static_cast<std::int64_t>(count - kept);
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
    if (kept == mesh.vertices.size())
    {
        return;
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

/// About the centre of a box of these sides [m] and of this mass [kg].
Eigen::Matrix3d boxInertia(const Eigen::Vector3d& sides, double mass)
{
    const Eigen::Vector3d squared = sides.cwiseAbs2();
    return (mass / 12.0) *
           (Eigen::Vector3d::Constant(squared.sum()) - squared).asDiagonal().toDenseMatrix();
}

MassProperties boxMassProperties(const Eigen::AlignedBox3d& box)
{
    MassProperties result;
    if (box.isEmpty())
    {
        return result;
    }
    result.volume = box.sizes().prod();
    result.center = box.center();
    result.inertia = boxInertia(box.sizes(), result.volume);
    return result;
}

bool isFlat(double volume, const Eigen::AlignedBox3d& box)
{
    const double diagonal = box.diagonal().norm();
    return !(volume > kFlatVolume * diagonal * diagonal * diagonal);
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
    const auto isFinite = [](const Eigen::Vector3d& vertex) { return vertex.allFinite(); };
    const auto isVertex = [count = static_cast<std::uint32_t>(mesh.vertices.size())](std::int32_t i)
    { return static_cast<std::uint32_t>(i) < count; };
    const auto isGood = [&](const Triangle& t)
    { return isVertex(t[0]) && isVertex(t[1]) && isVertex(t[2]); };
    if (std::ranges::all_of(mesh.vertices, isFinite) && std::ranges::all_of(mesh.triangles, isGood))
    {
        return;
    }
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
    const auto isFlat = [&](const Triangle& t) { return hasZeroArea(mesh, t); };
    const std::vector<std::size_t> flat =
        collected<std::size_t>(mesh.triangles.size(),
                               [&](std::size_t i, std::vector<std::size_t>& found)
                               {
                                   if (isFlat(mesh.triangles[i]))
                                   {
                                       found.push_back(i);
                                   }
                               });
    if (!flat.empty() && !isWatertight(mesh))
    {
        repair.degenerateTriangles +=
            static_cast<std::int64_t>(std::erase_if(mesh.triangles, isFlat));
    }
    dropUnreferencedVertices(mesh);
    repair.unreferencedVertices =
        static_cast<std::int64_t>(verticesBefore - mesh.vertices.size()) - repair.mergedVertices;
    return repair;
}

bool isWatertight(const TriangleMesh& mesh)
{
    if (mesh.triangles.empty())
    {
        return false;
    }
    // The ends of the edges that begin at each vertex, one behind the other.
    std::vector<std::size_t> begin(mesh.vertices.size() + 1, 0);
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t from : t)
        {
            ++begin[static_cast<std::size_t>(from)];
        }
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::int32_t> ends(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t i = 0; i < 3; ++i)
        {
            ends[--begin[static_cast<std::size_t>(t[i])]] = t[(i + 1) % 3];
        }
    }
    const auto endsOf = [&](std::size_t vertex)
    { return std::span(ends).subspan(begin[vertex], begin[vertex + 1] - begin[vertex]); };
    for (std::size_t vertex = 0; vertex < mesh.vertices.size(); ++vertex)
    {
        const std::span<std::int32_t> own = endsOf(vertex);
        std::ranges::sort(own);
        if (std::ranges::adjacent_find(own) != own.end())
        {
            return false;  // two triangles on the same side of an edge
        }
    }
    for (std::size_t vertex = 0; vertex < mesh.vertices.size(); ++vertex)
    {
        for (const std::int32_t end : endsOf(vertex))
        {
            if (!std::ranges::binary_search(endsOf(static_cast<std::size_t>(end)),
                                            static_cast<std::int32_t>(vertex)))
            {
                return false;  // an open edge
            }
        }
    }
    return true;
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
    if (isFlat(volume, box))
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

Eigen::Matrix3d inertiaAtMass(const TriangleMesh& mesh, double mass)
{
    const Eigen::AlignedBox3d box = bounds(mesh);
    const MassProperties solid = massProperties(mesh);
    return isFlat(solid.volume, box) ? boxInertia(box.sizes(), mass)
                                     : Eigen::Matrix3d(solid.inertia * (mass / solid.volume));
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
