#include "robots/shapes/polygonize.h"

#include "robots/shapes/remesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <unordered_map>
#include <vector>

namespace bullet_ccd::shapes
{
namespace
{
constexpr int kBlock = 8;             // cells a block
constexpr double kLeastShare = 0.02;  // vertices keep off grid nodes, so that no triangle vanishes

/// Corners of the six tetrahedra of a cube: from corner 0 to corner 7, one axis after another.
/// A corner is a mask of the axes (1 = x, 2 = y, 4 = z) along which it lies on the far side.
constexpr std::array<std::array<unsigned, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

class Marcher
{
public:
    Marcher(const Solid& solid, const Eigen::AlignedBox3d& box, double cell)
        : m_solid(solid), m_origin(box.min()), m_cell(cell)
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            m_blocks[axis] = static_cast<int>(std::ceil(box.sizes()[axis] / (cell * kBlock)));
        }
    }

    TriangleMesh run()
    {
        // A block is empty where the distance in its middle exceeds the way to its corners; a
        // quarter more for tubes, whose tapering adds to the slope.
        const double reach = 1.25 * 0.5 * kBlock * m_cell * std::sqrt(3.0);
        for (int z = 0; z < m_blocks.z(); ++z)
        {
            for (int y = 0; y < m_blocks.y(); ++y)
            {
                for (int x = 0; x < m_blocks.x(); ++x)
                {
                    const Eigen::Vector3i first = kBlock * Eigen::Vector3i(x, y, z);
                    const Eigen::Vector3d middle =
                        node(first) + Eigen::Vector3d::Constant(0.5 * kBlock * m_cell);
                    if (std::abs(m_solid(middle)) <= reach)
                    {
                        marchBlock(first);
                    }
                }
            }
        }
        return std::move(m_mesh);
    }

private:
    [[nodiscard]] Eigen::Vector3d node(const Eigen::Vector3i& index) const
    {
        return m_origin + m_cell * index.cast<double>();
    }

    void marchBlock(const Eigen::Vector3i& first)
    {
        constexpr int kNodes = kBlock + 1;
        std::array<double, kNodes * kNodes * kNodes> values{};
        const auto at = [&](int x, int y, int z) -> double&
        { return values[static_cast<std::size_t>((z * kNodes + y) * kNodes + x)]; };
        for (int i = 0; i < kNodes * kNodes * kNodes; ++i)
        {
            const Eigen::Vector3i local(i % kNodes, i / kNodes % kNodes, i / (kNodes * kNodes));
            at(local.x(), local.y(), local.z()) = m_solid(node(first + local));
        }
        for (int i = 0; i < kBlock * kBlock * kBlock; ++i)
        {
            const Eigen::Vector3i local(i % kBlock, i / kBlock % kBlock, i / (kBlock * kBlock));
            std::array<double, 8> corners{};
            for (unsigned mask = 0; mask < 8; ++mask)
            {
                const Eigen::Vector3i corner = local + offset(mask);
                corners[mask] = at(corner.x(), corner.y(), corner.z());
            }
            marchCube(first + local, corners);
        }
    }

    void marchCube(const Eigen::Vector3i& cube, const std::array<double, 8>& values)
    {
        const auto inside = std::ranges::count_if(values, [](double v) { return v < 0.0; });
        if (inside == 0 || inside == 8)
        {
            return;
        }
        for (const auto& tetrahedron : kTetrahedra)
        {
            std::vector<unsigned> in;
            std::vector<unsigned> out;
            for (const unsigned mask : tetrahedron)
            {
                (values[mask] < 0.0 ? in : out).push_back(mask);
            }
            std::vector<std::int32_t> ring;
            for (std::size_t i = 0; i < in.size(); ++i)
            {
                for (std::size_t j = 0; j < out.size(); ++j)
                {
                    // Back and forth, so that two by two edges come out in ring order.
                    const std::size_t k = i % 2 == 0 ? j : out.size() - 1 - j;
                    ring.push_back(vertexBetween(cube, values, in[i], out[k]));
                }
            }
            if (!ring.empty())
            {
                addPolygon(ring, outward(in, out));
            }
        }
    }

    /// From the middle of the inner to the middle of the outer corners.
    static Eigen::Vector3d outward(const std::vector<unsigned>& in,
                                   const std::vector<unsigned>& out)
    {
        const auto middle = [](const std::vector<unsigned>& masks)
        {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (const unsigned mask : masks)
            {
                sum += offset(mask).cast<double>();
            }
            return Eigen::Vector3d(sum / static_cast<double>(masks.size()));
        };
        return middle(out) - middle(in);
    }

    void addPolygon(std::vector<std::int32_t> ring, const Eigen::Vector3d& direction)
    {
        const auto at = [&](std::size_t i) -> const Eigen::Vector3d&
        { return m_mesh.vertices[static_cast<std::size_t>(ring[i])]; };
        const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0));
        if (normal.dot(direction) < 0.0)
        {
            std::ranges::reverse(ring);
        }
        for (std::size_t i = 1; i + 1 < ring.size(); ++i)
        {
            m_mesh.triangles.push_back({ring[0], ring[i], ring[i + 1]});
        }
    }

    static Eigen::Vector3i offset(unsigned mask)
    {
        return {static_cast<int>(mask & 1U),
                static_cast<int>((mask >> 1U) & 1U),
                static_cast<int>((mask >> 2U) & 1U)};
    }

    /// The one vertex on the edge between two corners of a cube, shared by all cubes around it.
    std::int32_t vertexBetween(const Eigen::Vector3i& cube,
                               const std::array<double, 8>& values,
                               unsigned a,
                               unsigned b)
    {
        const unsigned low = std::min(a, b);
        const unsigned high = std::max(a, b);
        const Eigen::Vector3i base = cube + offset(low);
        const Eigen::Vector3i nodes = kBlock * m_blocks + Eigen::Vector3i::Ones();
        const std::int64_t nodeIndex =
            (static_cast<std::int64_t>(base.z()) * nodes.y() + base.y()) * nodes.x() + base.x();
        const auto [entry, isNew] =
            m_vertexOfEdge.try_emplace(8 * nodeIndex + static_cast<std::int64_t>(low ^ high),
                                       static_cast<std::int32_t>(m_mesh.vertices.size()));
        if (isNew)
        {
            const double t = std::clamp(
                values[low] / (values[low] - values[high]), kLeastShare, 1.0 - kLeastShare);
            m_mesh.vertices.emplace_back((1.0 - t) * node(base) + t * node(cube + offset(high)));
        }
        return entry->second;
    }

    const Solid& m_solid;
    Eigen::Vector3d m_origin;
    double m_cell;
    Eigen::Vector3i m_blocks = Eigen::Vector3i::Zero();
    TriangleMesh m_mesh;
    std::unordered_map<std::int64_t, std::int32_t> m_vertexOfEdge;
};
}  // namespace

TriangleMesh polygonize(const Solid& solid,
                        const Eigen::AlignedBox3d& box,
                        const PolygonizeOptions& options)
{
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(2.0 * options.cell);
    const Eigen::AlignedBox3d grown(box.min() - margin, box.max() + margin);
    const TriangleMesh fine = Marcher(solid, grown, options.cell).run();
    if (!isWatertight(fine))
    {
        throw std::runtime_error("polygonize: " + std::to_string(fine.triangles.size()) +
                                 " triangles do not close: the solid leaves its box");
    }
    return remesh(fine, solid, options);
}
}  // namespace bullet_ccd::shapes
