#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/deformable/surface_data.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

namespace bullet_ccd
{
namespace
{
/// Sets of vertices that count as one.
class VertexSets
{
public:
    explicit VertexSets(std::size_t count) : m_parents(count)
    {
        std::iota(m_parents.begin(), m_parents.end(), 0);
    }
    std::int32_t find(std::int32_t v)
    {
        while (parent(v) != v)
        {
            v = parent(v) = parent(parent(v));
        }
        return v;
    }
    void join(std::int32_t a, std::int32_t b) { parent(find(b)) = find(a); }
    std::vector<std::int32_t> labels()
    {
        std::vector<std::int32_t> result(m_parents.size());
        for (std::size_t v = 0; v < result.size(); ++v)
        {
            result[v] = find(static_cast<std::int32_t>(v));
        }
        return result;
    }

private:
    std::int32_t& parent(std::int32_t v) { return m_parents[static_cast<std::size_t>(v)]; }

    std::vector<std::int32_t> m_parents;
};

std::string placeText(const Eigen::Vector3d& x)
{
    return "(" + std::to_string(x.x()) + ", " + std::to_string(x.y()) + ", " +
           std::to_string(x.z()) + ")";
}

/// Vertices of triangles, in the order of their places.
std::vector<std::int32_t> verticesByPlace(const TriangleMesh& mesh)
{
    std::vector<std::int32_t> order;
    for (const Triangle& triangle : mesh.triangles)
    {
        order.insert(order.end(), triangle.begin(), triangle.end());
    }
    std::ranges::sort(order);
    order.erase(std::ranges::unique(order).begin(), order.end());
    const auto key = [&](std::int32_t v)
    {
        const Eigen::Vector3d& x = mesh.vertices[static_cast<std::size_t>(v)];
        return std::tuple(x.x(), x.y(), x.z(), v);
    };
    std::ranges::sort(order, [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
    return order;
}

void joinDuplicates(const TriangleMesh& mesh, bool areWelded, VertexSets& sets)
{
    const std::vector<std::int32_t> order = verticesByPlace(mesh);
    for (std::size_t i = 1; i < order.size(); ++i)
    {
        const std::int32_t a = order[i - 1];
        const std::int32_t b = order[i];
        const Eigen::Vector3d& x = mesh.vertices[static_cast<std::size_t>(a)];
        if (x != mesh.vertices[static_cast<std::size_t>(b)])
        {
            continue;
        }
        if (!areWelded && sets.find(a) != sets.find(b))
        {
            throw std::invalid_argument(
                "deformable surface: vertices " + std::to_string(a) + " and " + std::to_string(b) +
                " are both at " + placeText(x) +
                ", so their triangles would touch at once: merge them, or set weldDuplicates");
        }
        sets.join(a, b);
    }
}

void checkPlaces(std::span<const Eigen::Vector3d> places, std::size_t count, const char* when)
{
    require(places.size() == count,
            "deformable surface: " + std::to_string(places.size()) + " vertices at the " + when +
                " of the step instead of " + std::to_string(count) +
                ": a mesh whose topology changes needs a new surface");
    for (std::size_t v = 0; v < places.size(); ++v)
    {
        if (!isPlace(places[v]))
        {
            throw std::invalid_argument("deformable surface: vertex " + std::to_string(v) +
                                        " is at " + placeText(places[v]) + " at the " + when +
                                        " of the step: give finite coordinates within 1e12");
        }
    }
}

template <class T>
std::size_t bytesOf(const std::vector<T>& values)
{
    return values.capacity() * sizeof(T);
}
}  // namespace

DeformableSurface::DeformableSurface(const TriangleMesh& rest,
                                     const DeformableSurfaceOptions& options)
    : m_data(std::make_unique<Data>())
{
    checkMesh(rest, "deformable surface");
    checkPlaces(rest.vertices, rest.vertices.size(), "start");
    VertexSets sets(rest.vertices.size());
    for (const std::array<std::int32_t, 2>& seam : options.seams)
    {
        for (const std::int32_t v : seam)
        {
            require(v >= 0 && static_cast<std::size_t>(v) < rest.vertices.size(),
                    "deformable surface: a seam names vertex " + std::to_string(v) +
                        ", which the mesh does not have: give indices below " +
                        std::to_string(rest.vertices.size()));
        }
        sets.join(seam[0], seam[1]);
    }
    joinDuplicates(rest, options.weldDuplicates, sets);
    m_data->meshVertices = rest.vertices.size();
    m_data->meshTriangles = rest.triangles.size();
    buildPatches(rest, sets.labels(), *m_data);
    refitSurface(rest.vertices, rest.vertices, 1, *m_data);
}

DeformableSurface::~DeformableSurface() = default;
DeformableSurface::DeformableSurface(DeformableSurface&&) noexcept = default;
DeformableSurface& DeformableSurface::operator=(DeformableSurface&&) noexcept = default;

void DeformableSurface::setStep(std::span<const Eigen::Vector3d> start,
                                std::span<const Eigen::Vector3d> end,
                                int threads)
{
    require(threads > 0, "deformable surface: a step needs at least one thread");
    checkPlaces(start, m_data->meshVertices, "start");
    checkPlaces(end, m_data->meshVertices, "end");
    refitSurface(start, end, threads, *m_data);
}

void DeformableSurface::keepStep()
{
    for (std::vector<std::uint8_t>* idle :
         {&m_data->vertexIdle, &m_data->patchIdle, &m_data->nodeIdle})
    {
        for (std::size_t i = 0; i < idle->size() && !m_data->isUnchanged; ++i)
        {
            (*idle)[i] |= kUnchanged;
        }
    }
    m_data->isUnchanged = true;
}

std::size_t DeformableSurface::vertexCount() const
{
    return m_data->meshVertices;
}

std::size_t DeformableSurface::triangleCount() const
{
    return m_data->meshTriangles;
}

std::size_t DeformableSurface::memory() const
{
    const Data& d = *m_data;
    return sizeof(Data) + bytesOf(d.patches) + bytesOf(d.nodes) + bytesOf(d.meshVertex) +
           bytesOf(d.steps) + bytesOf(d.patchBoxes) + bytesOf(d.nodeBoxes) + bytesOf(d.vertexIdle) +
           bytesOf(d.patchIdle) + bytesOf(d.nodeIdle);
}
}  // namespace bullet_ccd
