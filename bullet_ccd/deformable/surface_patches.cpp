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
/// Faces that are cut into patches together.
constexpr std::size_t kFacesAtOnce = 128;

class PatchBuilder
{
public:
    PatchBuilder(const TriangleMesh& mesh,
                 const std::vector<std::int32_t>& labels,
                 DeformableSurface::Data& data)
        : m_mesh(mesh),
          m_labels(labels),
          m_data(data),
          m_numbers(mesh.vertices.size(), kNone),
          m_local(mesh.vertices.size(), kNone)
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
        cutToPatches({0, m_order.size()});
        (void)makeNode({0, m_patches.size()});
        // An edge hangs on the lower of the numbers of its vertices: the last one made there, and
        // from each edge to the one before.
        m_lastEdge.assign(m_mesh.vertices.size(), kNone);
        m_edges.reserve(m_order.size() * 3 / 2 + 16);
        m_data.meshVertex.reserve(m_order.size() / 2 + 16);
        m_data.patches.reserve(m_patches.size());
        for (const GrownPatch& patch : m_patches)
        {
            addPatch(patch.faces);
        }
        m_data.meshVertex.shrink_to_fit();
        m_data.nodes.shrink_to_fit();
    }

private:
    /// A part of a list, by positions.
    struct Range
    {
        std::size_t begin = 0;
        std::size_t end = 0;
        [[nodiscard]] std::size_t size() const { return end - begin; }
    };
    struct GrownPatch
    {
        Range faces;  ///< in m_order
        Eigen::Vector3d centre;
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

    [[nodiscard]] const Eigen::Vector3d& centroid(std::int32_t face) const
    {
        return m_centroids[static_cast<std::size_t>(face)];
    }

    /// Puts the items of the range before `middle` that are lower along its longest axis.
    template <class Item, class CentreOf>
    static void cut(std::vector<Item>& items,
                    const Range& range,
                    std::size_t middle,
                    const CentreOf& centreOf)
    {
        Eigen::AlignedBox3d box;
        for (std::size_t i = range.begin; i < range.end; ++i)
        {
            box.extend(centreOf(items[i]));
        }
        Eigen::Index axis = 0;
        box.sizes().maxCoeff(&axis);
        const auto at = [&](std::size_t position)
        { return items.begin() + static_cast<std::ptrdiff_t>(position); };
        std::nth_element(at(range.begin),
                         at(middle),
                         at(range.end),
                         [&](const Item& a, const Item& b)
                         { return centreOf(a)[axis] < centreOf(b)[axis]; });
    }

    void cutToPatches(const Range& range)
    {
        if (range.size() <= kFacesAtOnce)
        {
            growPatches(range);
            return;
        }
        const std::size_t middle = range.begin + range.size() / 2;
        cut(m_order, range, middle, [this](std::int32_t face) { return centroid(face); });
        cutToPatches({range.begin, middle});
        cutToPatches({middle, range.end});
    }

    /// What has grown so far of a patch.
    struct Growth
    {
        std::size_t faces = 0;
        int vertices = 0;
        int edges = 0;
        std::array<std::uint32_t, kPatchVertices> neighbours{};  ///< by vertex, a bit each
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();           ///< of the centroids
    };

    /// How many vertices of the triangle the growing patch does not have.
    [[nodiscard]] int newVertices(const Triangle& t) const
    {
        return static_cast<int>(std::ranges::count_if(
            t, [this](std::int32_t v) { return m_local[static_cast<std::size_t>(v)] == kNone; }));
    }

    /// Adds the face, unless it makes the patch too large.
    bool grow(std::int32_t face, Growth& patch)
    {
        const Triangle& t = m_mesh.triangles[static_cast<std::size_t>(face)];
        if (patch.vertices + newVertices(t) > kPatchVertices)
        {
            return false;
        }
        Growth grown = patch;
        std::array<std::int32_t, 3> local{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::int32_t known = m_local[static_cast<std::size_t>(t[k])];
            const auto before = std::find(t.begin(), t.begin() + k, t[k]);  // of a degenerate one
            local[k] = known != kNone ? known
                       : before != t.begin() + k
                           ? local[static_cast<std::size_t>(before - t.begin())]
                           : grown.vertices++;
        }
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto a = static_cast<unsigned>(local[k]);
            const auto b = static_cast<unsigned>(local[(k + 1) % 3]);
            if (a != b && (grown.neighbours[a] >> b & 1U) == 0)
            {
                grown.neighbours[a] |= 1U << b;
                grown.neighbours[b] |= 1U << a;
                ++grown.edges;
            }
        }
        if (grown.edges > kPatchEdges)
        {
            return false;
        }
        for (std::size_t k = 0; k < 3; ++k)
        {
            m_local[static_cast<std::size_t>(t[k])] = local[k];
        }
        patch = grown;
        patch.sum += centroid(face);
        ++patch.faces;
        return true;
    }

    /// Cuts a few faces into patches: each begins at the end of what is left along the longest axis
    /// and takes the face that adds the fewest vertices, of these the nearest, as long as one fits.
    void growPatches(const Range& range)
    {
        cut(m_order, range, range.begin, [this](std::int32_t face) { return centroid(face); });
        for (std::size_t begin = range.begin; begin < range.end;)
        {
            Growth patch;
            std::size_t next = begin;
            do
            {
                std::swap(m_order[begin + patch.faces], m_order[next]);
                if (!grow(m_order[begin + patch.faces], patch))
                {
                    break;
                }
                next = range.end;
                int fewest = 4;
                double nearest = 0.0;
                const Eigen::Vector3d centre = patch.sum / static_cast<double>(patch.faces);
                for (std::size_t i = begin + patch.faces; i < range.end; ++i)
                {
                    const int count = newVertices(triangle(i));
                    if (count > fewest || patch.vertices + count > kPatchVertices)
                    {
                        continue;
                    }
                    const double distance = (centroid(m_order[i]) - centre).squaredNorm();
                    if (count < fewest || distance < nearest)
                    {
                        fewest = count;
                        nearest = distance;
                        next = i;
                    }
                }
            } while (next != range.end && patch.faces < kPatchFaces);
            const Range faces{begin, begin + patch.faces};
            for (std::size_t i = faces.begin; i < faces.end; ++i)
            {
                for (const std::int32_t v : triangle(i))
                {
                    m_local[static_cast<std::size_t>(v)] = kNone;
                }
            }
            m_patches.push_back({faces, patch.sum / static_cast<double>(patch.faces)});
            begin = faces.end;
            if (begin < range.end)
            {
                cut(m_order,
                    {begin, range.end},
                    begin,
                    [this](std::int32_t face) { return centroid(face); });
            }
        }
    }

    /// A node over patches; all of its children but one are as full as they can be.
    std::int32_t makeNode(const Range& range)
    {
        const std::size_t index = m_data.nodes.size();
        m_data.nodes.emplace_back();
        std::size_t ofChild = 1;  // patches
        while (ofChild * kChildren < range.size())
        {
            ofChild *= kChildren;
        }
        std::vector<Range> parts{range};
        for (std::size_t i = 0; i < parts.size();)
        {
            const Range whole = parts[i];
            if (whole.size() <= ofChild)
            {
                ++i;
                continue;
            }
            const std::size_t children = (whole.size() + ofChild - 1) / ofChild;
            const std::size_t middle = whole.begin + children / 2 * ofChild;
            cut(m_patches, whole, middle, [](const GrownPatch& patch) { return patch.centre; });
            parts[i] = {whole.begin, middle};
            parts.push_back({middle, whole.end});
        }
        std::ranges::sort(parts, {}, &Range::begin);
        std::array<std::int32_t, kChildren> children{};
        for (std::size_t i = 0; i < parts.size(); ++i)
        {
            children[i] = parts[i].size() == 1 ? ~static_cast<std::int32_t>(parts[i].begin)
                                               : makeNode(parts[i]);
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
        for (std::uint8_t i = 0; i < patch.vertices; ++i)
        {
            if (patch.vertex[i] == number)
            {
                return i;
            }
        }
        const std::uint8_t local = patch.vertices++;
        patch.vertex[local] = number;
        patch.label[local] = m_labels[static_cast<std::size_t>(v)];
        patch.own |= isNew ? 1U << static_cast<unsigned>(local) : 0U;
        return local;
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
            const std::array<std::int32_t, 2>& edge = m_edges[static_cast<std::size_t>(e)];
            if (std::max(edge[0], edge[1]) == high)
            {
                return;
            }
        }
        m_edgeBefore.push_back(last);
        last = static_cast<std::int32_t>(m_edges.size());
        // In the order of the mesh, so that answers do not depend on the patches.
        if (meshVertexOf(patch, b) < meshVertexOf(patch, a))
        {
            std::swap(a, b);
        }
        m_edges.push_back({patch.vertex[a], patch.vertex[b]});
        patch.edgeA[patch.edges] = a;
        patch.edgeB[patch.edges] = b;
        ++patch.edges;
    }

    void addPatch(const Range& range)
    {
        SurfacePatch patch{};
        std::fill_n(patch.vertex, kPatchVertices, kNone);
        std::fill_n(patch.label, kPatchVertices, kNone);
        patch.faces = static_cast<std::uint8_t>(range.size());
        for (std::size_t i = range.begin; i < range.end; ++i)
        {
            const Triangle& t = triangle(i);
            const std::array<std::uint8_t, 3> local{
                localVertex(t[0], patch), localVertex(t[1], patch), localVertex(t[2], patch)};
            const std::size_t face = i - range.begin;
            patch.faceA[face] = local[0];
            patch.faceB[face] = local[1];
            patch.faceC[face] = local[2];
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
    std::vector<std::int32_t> m_local;  ///< in the patch that grows, by vertex of the mesh
    std::vector<GrownPatch> m_patches;
    std::vector<std::array<std::int32_t, 2>> m_edges;
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
    data.patchBoxes.resize(data.patches.size());
    data.nodeBoxes.resize(data.nodes.size());
    data.vertexIdle.resize(data.meshVertex.size());
    data.patchIdle.resize(data.patches.size());
    data.nodeIdle.resize(data.nodes.size());
}
}  // namespace bullet_ccd
