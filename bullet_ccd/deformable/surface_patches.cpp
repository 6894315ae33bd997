// Cuts a mesh into patches and builds the hierarchy over them: median cuts along the longest axis.
#include "bullet_ccd/deformable/surface_data.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

namespace bullet_ccd
{
namespace
{
constexpr std::size_t kChildren = 8;

class PatchBuilder
{
public:
    PatchBuilder(const TriangleMesh& mesh,
                 const std::vector<std::int32_t>& labels,
                 DeformableSurface::Data& data)
        : m_mesh(mesh), m_labels(labels), m_data(data), m_numbers(mesh.vertices.size(), kNone)
    {
        m_order = distinctTriangles(mesh);
        m_centroids.resize(mesh.triangles.size());
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        {
            const Triangle& t = mesh.triangles[i];
            m_centroids[i] = vertex(t[0]) + vertex(t[1]) + vertex(t[2]);
        }
    }

    void build()
    {
        (void)makeNode({0, m_order.size()});
        // An edge hangs on the lower of the numbers of its vertices: the last one made there, and
        // from each edge to the one before.
        m_lastEdge.assign(m_mesh.vertices.size(), kNone);
        m_data.faces.reserve(m_order.size());
        m_data.edges.reserve(m_order.size() * 3 / 2 + 16);
        m_data.meshVertex.reserve(m_order.size() / 2 + 16);
        m_data.patches.reserve(m_leaves.size());
        for (const Range& leaf : m_leaves)
        {
            addPatch(leaf);
        }
        m_data.edges.shrink_to_fit();
        m_data.meshVertex.shrink_to_fit();
        m_data.nodes.shrink_to_fit();
    }

private:
    /// Triangles by their positions in m_order.
    struct Range
    {
        std::size_t begin = 0;
        std::size_t end = 0;
        [[nodiscard]] std::size_t size() const { return end - begin; }
    };

    static std::vector<std::int32_t> distinctTriangles(const TriangleMesh& mesh)
    {
        const auto sorted = [&](std::int32_t i)
        {
            Triangle t = mesh.triangles[static_cast<std::size_t>(i)];
            std::ranges::sort(t);
            return t;
        };
        std::vector<std::int32_t> order(mesh.triangles.size());
        std::iota(order.begin(), order.end(), 0);
        std::vector<std::pair<Triangle, std::int32_t>> keys;
        keys.reserve(order.size());
        for (const std::int32_t i : order)
        {
            keys.emplace_back(sorted(i), i);
        }
        std::ranges::sort(keys);
        order.clear();
        for (std::size_t i = 0; i < keys.size(); ++i)
        {
            if (i == 0 || keys[i].first != keys[i - 1].first)
            {
                order.push_back(keys[i].second);
            }
        }
        std::ranges::sort(order);
        return order;
    }

    [[nodiscard]] const Eigen::Vector3d& vertex(std::int32_t v) const
    {
        return m_mesh.vertices[static_cast<std::size_t>(v)];
    }
    [[nodiscard]] const Triangle& triangle(std::size_t position) const
    {
        return m_mesh.triangles[static_cast<std::size_t>(m_order[position])];
    }

    [[nodiscard]] bool fitsPatch(const Range& range) const
    {
        if (range.size() > kPatchFaces)
        {
            return false;
        }
        std::array<std::int32_t, 3 * kPatchFaces> corners{};
        std::size_t count = 0;
        for (std::size_t i = range.begin; i < range.end; ++i)
        {
            for (const std::int32_t v : triangle(i))
            {
                corners[count++] = v;
            }
        }
        const auto last = corners.begin() + static_cast<std::ptrdiff_t>(count);
        std::sort(corners.begin(), last);
        return std::unique(corners.begin(), last) - corners.begin() <= kPatchVertices;
    }

    /// The first position of the second half; patches of the first half are full.
    std::size_t cut(const Range& range)
    {
        Eigen::AlignedBox3d box;
        for (std::size_t i = range.begin; i < range.end; ++i)
        {
            box.extend(m_centroids[static_cast<std::size_t>(m_order[i])]);
        }
        Eigen::Index axis = 0;
        box.sizes().maxCoeff(&axis);
        std::size_t half = range.size() / 2;
        if (range.size() > kPatchFaces)
        {
            half = (half + kPatchFaces - 1) / kPatchFaces * kPatchFaces;
        }
        const auto at = [&](std::size_t position)
        { return m_order.begin() + static_cast<std::ptrdiff_t>(position); };
        const auto isBefore = [&](std::int32_t a, std::int32_t b)
        {
            const double x = m_centroids[static_cast<std::size_t>(a)][axis];
            const double y = m_centroids[static_cast<std::size_t>(b)][axis];
            return x < y || (x == y && a < b);
        };
        std::nth_element(at(range.begin), at(range.begin + half), at(range.end), isBefore);
        return range.begin + half;
    }

    std::int32_t makeNode(const Range& range)
    {
        const std::size_t index = m_data.nodes.size();
        m_data.nodes.emplace_back();
        std::vector<Range> parts{range};
        while (parts.size() < kChildren)
        {
            // The largest that is no patch yet.
            std::size_t largest = parts.size();
            for (std::size_t i = 0; i < parts.size(); ++i)
            {
                if ((largest == parts.size() || parts[i].size() > parts[largest].size()) &&
                    !fitsPatch(parts[i]))
                {
                    largest = i;
                }
            }
            if (largest == parts.size())
            {
                break;
            }
            const Range whole = parts[largest];
            const std::size_t middle = cut(whole);
            parts[largest] = {whole.begin, middle};
            parts.push_back({middle, whole.end});
        }
        std::ranges::sort(parts, {}, &Range::begin);
        std::array<std::int32_t, kChildren> children{};
        for (std::size_t i = 0; i < parts.size(); ++i)
        {
            if (fitsPatch(parts[i]))
            {
                children[i] = ~static_cast<std::int32_t>(m_leaves.size());
                m_leaves.push_back(parts[i]);
            }
            else
            {
                children[i] = makeNode(parts[i]);
            }
        }
        SurfaceNode& node = m_data.nodes[index];
        node.count = static_cast<std::int32_t>(parts.size());
        std::ranges::copy(children, node.child);
        return static_cast<std::int32_t>(index);
    }

    /// Index in the patch of a vertex of the mesh; it belongs to the first patch that has it.
    std::uint8_t localVertex(std::int32_t v, SurfacePatch& patch)
    {
        std::int32_t& number = m_numbers[static_cast<std::size_t>(v)];
        const bool isNew = number == kNone;
        if (isNew)
        {
            number = static_cast<std::int32_t>(m_data.meshVertex.size());
            m_data.meshVertex.push_back(v);
        }
        for (std::int32_t i = 0; i < patch.vertices; ++i)
        {
            if (patch.vertex[i] == number)
            {
                return static_cast<std::uint8_t>(i);
            }
        }
        const std::int32_t local = patch.vertices++;
        patch.vertex[local] = number;
        patch.label[local] = m_labels[static_cast<std::size_t>(v)];
        patch.own |= isNew ? 1U << static_cast<unsigned>(local) : 0U;
        return static_cast<std::uint8_t>(local);
    }

    [[nodiscard]] std::int32_t meshVertexOf(const SurfacePatch& patch, std::uint8_t local) const
    {
        return m_data.meshVertex[static_cast<std::size_t>(patch.vertex[local])];
    }

    void addEdge(std::uint8_t a, std::uint8_t b, SurfacePatch& patch)
    {
        const std::int32_t low = std::min(patch.vertex[a], patch.vertex[b]);
        const std::int32_t high = std::max(patch.vertex[a], patch.vertex[b]);
        std::int32_t& last = m_lastEdge[static_cast<std::size_t>(low)];
        for (std::int32_t e = last; e != kNone; e = m_edgeBefore[static_cast<std::size_t>(e)])
        {
            const std::array<std::int32_t, 2>& edge = m_data.edges[static_cast<std::size_t>(e)];
            if (std::max(edge[0], edge[1]) == high)
            {
                return;
            }
        }
        m_edgeBefore.push_back(last);
        last = static_cast<std::int32_t>(m_data.edges.size());
        // In the order of the mesh, so that answers do not depend on the patches.
        if (meshVertexOf(patch, b) < meshVertexOf(patch, a))
        {
            std::swap(a, b);
        }
        m_data.edges.push_back({patch.vertex[a], patch.vertex[b]});
        patch.edgeA[patch.edges] = a;
        patch.edgeB[patch.edges] = b;
        ++patch.edges;
    }

    void addPatch(const Range& range)
    {
        SurfacePatch patch{};
        std::fill_n(patch.vertex, kPatchVertices, kNone);
        std::fill_n(patch.label, kPatchVertices, kNone);
        patch.firstEdge = static_cast<std::int32_t>(m_data.edges.size());
        patch.firstFace = static_cast<std::int32_t>(range.begin);
        patch.faces = static_cast<std::int32_t>(range.size());
        for (std::size_t i = range.begin; i < range.end; ++i)
        {
            const Triangle& t = triangle(i);
            const std::array<std::uint8_t, 3> local{
                localVertex(t[0], patch), localVertex(t[1], patch), localVertex(t[2], patch)};
            const std::size_t face = i - range.begin;
            patch.faceA[face] = local[0];
            patch.faceB[face] = local[1];
            patch.faceC[face] = local[2];
            m_data.faces.push_back(
                {patch.vertex[local[0]], patch.vertex[local[1]], patch.vertex[local[2]]});
            for (std::size_t k = 0; k < 3; ++k)
            {
                if (local[k] != local[(k + 1) % 3])
                {
                    addEdge(local[k], local[(k + 1) % 3], patch);
                }
            }
        }
        m_data.patches.push_back(patch);
    }

    const TriangleMesh& m_mesh;
    const std::vector<std::int32_t>& m_labels;
    DeformableSurface::Data& m_data;
    std::vector<std::int32_t> m_numbers;  ///< of the vertices of the mesh
    std::vector<std::int32_t> m_order;    ///< triangles of the mesh
    std::vector<Eigen::Vector3d> m_centroids;
    std::vector<Range> m_leaves;
    std::vector<std::int32_t> m_lastEdge;
    std::vector<std::int32_t> m_edgeBefore;
};
}  // namespace

void buildPatches(const TriangleMesh& mesh,
                  const std::vector<std::int32_t>& labels,
                  DeformableSurface::Data& data)
{
    PatchBuilder(mesh, labels, data).build();
    data.steps.resize(data.meshVertex.size());
    data.lanes.resize(data.meshVertex.size());
    data.patchBoxes.resize(data.patches.size());
    data.nodeBoxes.resize(data.nodes.size());
    data.vertexIdle.resize(data.meshVertex.size());
    data.patchIdle.resize(data.patches.size());
    data.nodeIdle.resize(data.nodes.size());
}
}  // namespace bullet_ccd
