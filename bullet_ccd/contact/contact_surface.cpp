#include "bullet_ccd/contact/contact_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Bend of an edge that counts as none: single-precision coordinates bend fine flat meshes by less.
constexpr float kFlat = 2e-5F;
constexpr float kSmooth = 0.2F;

/// Zero for a triangle without area to speak of: with a height below 1e-13 of its length it is an
/// edge, as in triangleDistance().
Vector3d unitNormal(const std::array<Vector3d, 3>& c)
{
    const Vector3d n = (c[1] - c[0]).cross(c[2] - c[0]);
    const double longest = std::max(
        {(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(), (c[0] - c[2]).squaredNorm()});
    return n.squaredNorm() > 1e-26 * longest * longest ? Vector3d(n.stableNormalized())
                                                       : Vector3d::Zero();
}

/// 0, 1, ... , count - 1.
std::vector<std::int32_t> countedTo(std::size_t count)
{
    std::vector<std::int32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
}

/// True if the directions are all along one line but for `angle`, to both sides.
bool isStraight(std::span<const Vector3f> directions, float angle)
{
    bool opposite = false;
    for (const Vector3f& t : directions)
    {
        const bool same = t.dot(directions.front()) > 0.0F;
        const Vector3f off =
            same ? Vector3f(t - directions.front()) : Vector3f(t + directions.front());
        if (off.norm() > angle)
        {
            return false;
        }
        opposite = opposite || !same;
    }
    return opposite;
}

/// Prefix sums: where the entries of each key begin; one more at the end.
std::vector<std::int32_t> firstOf(const std::vector<std::pair<std::int32_t, Vector3f>>& entries,
                                  std::int32_t keys)
{
    std::vector<std::int32_t> first(static_cast<std::size_t>(keys) + 1, 0);
    for (const auto& [key, direction] : entries)
    {
        ++first[static_cast<std::size_t>(key) + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    return first;
}

std::vector<Vector3f> sortedByKey(std::vector<std::pair<std::int32_t, Vector3f>>& entries)
{
    std::stable_sort(entries.begin(),
                     entries.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    std::vector<Vector3f> directions;
    directions.reserve(entries.size());
    for (const auto& entry : entries)
    {
        directions.push_back(entry.second);
    }
    return directions;
}
}  // namespace

struct ContactSurface::Edges
{
    std::vector<std::array<std::int32_t, 2>> ends;  ///< vertices of each edge
    std::vector<Vector3d> directions;               ///< unit, from the first end
    std::vector<std::uint8_t> flat;
};

namespace
{
const SsvTree& opened(const SsvTree& tree)
{
    tree.openAll();
    return tree;
}
}  // namespace

ContactSurface::ContactSurface(const SsvTree& tree)
    : ContactSurface(opened(tree), countedTo(tree.mesh().triangles.size()))
{
}

ContactSurface::ContactSurface(const SsvTree& tree, std::span<const std::int32_t> inTree)
    : m_tree(&tree), m_slots(inTree.size())
{
    for (std::size_t i = 0; i < m_slots.size(); ++i)
    {
        m_slots[i].inTree = inTree[i];
        m_slots[i].normal = unitNormal(tree.corners(inTree[i]));
    }
    Edges edges;
    mergeVertices();
    placeEdges(edges);
    bendEdges(edges);
    placeVertexDirections(edges);
    assignOwners(edges);
}

void ContactSurface::mergeVertices()
{
    const TriangleMesh& mesh = m_tree->mesh();
    for (Slot& slot : m_slots)
    {
        const std::int32_t triangle = m_tree->triangle(slot.inTree);
        // Slots hold the corners in the same order, but begin with another one.
        const auto c = m_tree->corners(slot.inTree);
        const auto inMesh = m_tree->cornersOfTriangle(triangle);
        std::size_t shift = 0;
        while (shift < 2 && (c[0] != inMesh[shift] || c[1] != inMesh[(shift + 1) % 3]))
        {
            ++shift;
        }
        for (std::size_t k = 0; k < 3; ++k)
        {
            slot.vertices[k] = mesh.triangles[static_cast<std::size_t>(triangle)][(k + shift) % 3];
        }
    }
    const bool isWhole = m_slots.size() == mesh.triangles.size();
    std::vector<std::int32_t> used;
    if (isWhole)
    {
        used = countedTo(mesh.vertices.size());
    }
    else
    {
        for (const Slot& slot : m_slots)
        {
            used.insert(used.end(), slot.vertices.begin(), slot.vertices.end());
        }
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
    }
    const auto placeOf = [&](std::int32_t i) -> const Vector3d&
    {
        const std::int32_t vertex = used[static_cast<std::size_t>(i)];
        return mesh.vertices[static_cast<std::size_t>(vertex)];
    };
    std::vector<std::int32_t> order = countedTo(used.size());
    std::sort(order.begin(),
              order.end(),
              [&](std::int32_t x, std::int32_t y)
              {
                  const Vector3d& u = placeOf(x);
                  const Vector3d& v = placeOf(y);
                  return std::tie(u.x(), u.y(), u.z(), x) < std::tie(v.x(), v.y(), v.z(), y);
              });
    std::vector<std::int32_t> merged(used.size());
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        if (i == 0 || placeOf(order[i]) != placeOf(order[i - 1]))
        {
            m_meshVertices.push_back(used[static_cast<std::size_t>(order[i])]);
        }
        merged[static_cast<std::size_t>(order[i])] =
            static_cast<std::int32_t>(m_meshVertices.size()) - 1;
    }
    for (Slot& slot : m_slots)
    {
        for (std::int32_t& vertex : slot.vertices)
        {
            const auto at = isWhole ? used.begin() + vertex
                                    : std::lower_bound(used.begin(), used.end(), vertex);
            vertex = merged[static_cast<std::size_t>(at - used.begin())];
        }
    }
}

void ContactSurface::placeEdges(Edges& edges)
{
    struct Side
    {
        std::array<std::int32_t, 2> ends;
        std::size_t slot;
        std::size_t k;
    };
    std::vector<Side> sides;
    sides.reserve(3 * m_slots.size());
    for (std::size_t i = 0; i < m_slots.size(); ++i)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::int32_t from = m_slots[i].vertices[k];
            const std::int32_t to = m_slots[i].vertices[(k + 1) % 3];
            if (from != to)
            {
                sides.push_back({{std::min(from, to), std::max(from, to)}, i, k});
            }
        }
    }
    std::sort(sides.begin(),
              sides.end(),
              [](const Side& x, const Side& y)
              { return std::tie(x.ends, x.slot, x.k) < std::tie(y.ends, y.slot, y.k); });
    for (std::size_t s = 0; s < sides.size(); ++s)
    {
        Slot& slot = m_slots[sides[s].slot];
        const std::size_t k = sides[s].k;
        if (s == 0 || sides[s].ends != sides[s - 1].ends)
        {
            const auto c = corners(static_cast<std::int32_t>(sides[s].slot));
            const double sign = slot.vertices[k] == sides[s].ends[0] ? 1.0 : -1.0;
            edges.ends.push_back(sides[s].ends);
            edges.directions.emplace_back(sign * (c[(k + 1) % 3] - c[k]).stableNormalized());
        }
        slot.edges[k] = static_cast<std::int32_t>(edges.ends.size()) - 1;
    }
}

void ContactSurface::bendEdges(Edges& edges)
{
    const auto count = static_cast<std::int32_t>(edges.ends.size());
    // A triangle without area only joins its neighbours: they bend at all of its edges alike.
    std::vector<std::int32_t> group = countedTo(edges.ends.size());
    const auto rootOf = [&](std::int32_t edge)
    {
        while (group[static_cast<std::size_t>(edge)] != edge)
        {
            edge = group[static_cast<std::size_t>(edge)];
        }
        return edge;
    };
    std::vector<std::pair<std::int32_t, Vector3f>> into;
    for (std::size_t i = 0; i < m_slots.size(); ++i)
    {
        const Slot& slot = m_slots[i];
        const auto c = corners(static_cast<std::int32_t>(i));
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::int32_t edge = slot.edges[k];
            const std::int32_t next = slot.edges[(k + 1) % 3];
            if (slot.normal.isZero(0.0))
            {
                if (edge != kNone && next != kNone)
                {
                    group[static_cast<std::size_t>(rootOf(edge))] = rootOf(next);
                }
                continue;
            }
            const Vector3d along = c[(k + 1) % 3] - c[k];
            into.emplace_back(edge, slot.normal.cross(along).normalized().cast<float>());
        }
    }
    for (auto& entry : into)
    {
        entry.first = rootOf(entry.first);
    }
    const std::vector<std::int32_t> first = firstOf(into, count);
    const std::vector<Vector3f> directions = sortedByKey(into);
    for (std::int32_t edge = 0; edge < count; ++edge)
    {
        const std::span<const Vector3f> around = range(directions, first, rootOf(edge));
        m_edgeFirst.push_back(static_cast<std::int32_t>(m_edgeDirections.size()));
        m_edgeDirections.insert(m_edgeDirections.end(), around.begin(), around.end());
        edges.flat.push_back(isStraight(around, kFlat) ? 1 : 0);
        m_smooth.push_back(isStraight(around, kSmooth) ? 1 : 0);
    }
    m_edgeFirst.push_back(static_cast<std::int32_t>(m_edgeDirections.size()));
}

void ContactSurface::placeVertexDirections(const Edges& edges)
{
    std::vector<std::pair<std::int32_t, Vector3f>> from;
    from.reserve(2 * edges.ends.size());
    for (std::size_t e = 0; e < edges.ends.size(); ++e)
    {
        from.emplace_back(edges.ends[e][0], edges.directions[e].cast<float>());
        from.emplace_back(edges.ends[e][1], -edges.directions[e].cast<float>());
    }
    for (std::size_t i = 0; i < m_slots.size(); ++i)
    {
        const auto c = corners(static_cast<std::int32_t>(i));
        for (std::size_t k = 0; k < 3 && !m_slots[i].normal.isZero(0.0); ++k)
        {
            // Between two edges farther apart the surface can rise while both edges fall.
            constexpr double kObtuse = -0.5;
            const Vector3d u = (c[(k + 1) % 3] - c[k]).stableNormalized();
            const Vector3d v = (c[(k + 2) % 3] - c[k]).stableNormalized();
            if (u.dot(v) < kObtuse)
            {
                // Half way from u to v; their sum may vanish.
                const Vector3d half = m_slots[i].normal.cross(u - v).normalized();
                from.emplace_back(m_slots[i].vertices[k], half.cast<float>());
            }
        }
    }
    m_vertexFirst = firstOf(from, static_cast<std::int32_t>(m_meshVertices.size()));
    m_vertexDirections = sortedByKey(from);
}

void ContactSurface::assignOwners(const Edges& edges)
{
    std::vector<std::uint8_t> isSharp(m_meshVertices.size(), 0);
    std::vector<std::uint8_t> hasEdge(m_meshVertices.size(), 0);
    for (std::size_t e = 0; e < edges.ends.size(); ++e)
    {
        for (const std::int32_t vertex : edges.ends[e])
        {
            if (edges.flat[e] == 0)
            {
                isSharp[static_cast<std::size_t>(vertex)] = 1;
            }
            hasEdge[static_cast<std::size_t>(vertex)] = 1;
        }
    }
    std::vector<std::uint8_t> vertexTaken(m_meshVertices.size(), 0);
    std::vector<std::uint8_t> edgeTaken(edges.ends.size(), 0);
    for (Slot& slot : m_slots)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto bit = static_cast<std::uint8_t>(1U << k);
            const auto vertex = static_cast<std::size_t>(slot.vertices[k]);
            if (std::exchange(vertexTaken[vertex], 1) == 0 &&
                (isSharp[vertex] != 0 || hasEdge[vertex] == 0))
            {
                slot.ownVertices = static_cast<std::uint8_t>(slot.ownVertices | bit);
            }
            if (slot.edges[k] == kNone)
            {
                continue;
            }
            const auto edge = static_cast<std::size_t>(slot.edges[k]);
            const bool isOwner = std::exchange(edgeTaken[edge], 1) == 0;
            const int owned = isOwner ? bit : 0;
            if (edges.flat[edge] != 0)
            {
                slot.flatEdges = static_cast<std::uint8_t>(slot.flatEdges | owned);
            }
            else
            {
                slot.sharpEdges = static_cast<std::uint8_t>(slot.sharpEdges | bit);
                slot.ownEdges = static_cast<std::uint8_t>(slot.ownEdges | owned);
            }
        }
    }
}
}  // namespace bullet_ccd
