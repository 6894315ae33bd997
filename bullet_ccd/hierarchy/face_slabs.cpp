#include "bullet_ccd/hierarchy/face_slabs.h"

#include "bullet_ccd/hierarchy/ssv_node.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

/// Triangles whose normals agree.
struct Facing
{
    Vector3d area = Vector3d::Zero();  ///< twice the sum of their areas, along their normal
    std::int32_t triangles = 0;
};

/// Normals that agree to this much fall into one cell, unless they are at its border.
constexpr double kCell = 1e-6;

using Cell = std::array<std::int64_t, 3>;

/// The normals of the largest faces, the largest first.
std::vector<Vector3d> largestNormals(std::span<const Corners> corners)
{
    // A sample is enough: faces of few triangles cost little.
    constexpr std::size_t kSample = 4096;
    const std::size_t stride = (corners.size() + kSample - 1) / kSample;
    std::map<Cell, Facing> facings;
    for (std::size_t i = 0; i < corners.size(); i += stride)
    {
        const Corners& c = corners[i];
        Vector3d area = (c[1] - c[0]).cross(c[2] - c[0]);
        const double size = area.norm();
        if (!(size > 0.0))
        {
            continue;
        }
        Cell cell{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            cell[k] = std::llround(area[static_cast<Eigen::Index>(k)] / size / kCell);
        }
        if (cell < Cell{})  // both sides of a face are one
        {
            area = -area;
            cell = {-cell[0], -cell[1], -cell[2]};
        }
        Facing& facing = facings[cell];
        facing.area += area;
        ++facing.triangles;
    }
    std::vector<Vector3d> areas;
    for (const auto& [cell, facing] : facings)
    {
        if (facing.triangles >= FaceSlabs::kLeastTriangles)
        {
            areas.push_back(facing.area);
        }
    }
    std::stable_sort(areas.begin(),
                     areas.end(),
                     [](const Vector3d& a, const Vector3d& b)
                     { return a.squaredNorm() > b.squaredNorm(); });
    areas.resize(std::min(areas.size(), FaceSlabs::kMostNormals));
    for (Vector3d& area : areas)
    {
        area.normalize();
    }
    return areas;
}
}  // namespace

FaceSlabs findFaceSlabs(std::span<const SsvNode> nodes, std::span<const Corners> corners)
{
    FaceSlabs found{.normals = largestNormals(corners)};
    const std::size_t count = found.normals.size();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    found.slabs.assign(count * nodes.size(), {.low = kInfinity, .high = -kInfinity});
    for (std::size_t i = nodes.size(); i-- > 0;)  // children come after their parent
    {
        const SsvNode& node = nodes[i];
        for (std::size_t k = 0; k < count; ++k)
        {
            Slab& slab = found.slabs[i * count + k];
            const auto include = [&slab](double low, double high)
            {
                slab.low = std::min(slab.low, low);
                slab.high = std::max(slab.high, high);
            };
            if (node.isLeaf())
            {
                for (const Vector3d& corner : corners[static_cast<std::size_t>(node.first)])
                {
                    const double height = found.normals[k].dot(corner);
                    include(height, height);
                }
            }
            for (std::int32_t child = 0; child < node.count; ++child)
            {
                const Slab& below =
                    found.slabs[static_cast<std::size_t>(node.first + child) * count + k];
                include(below.low, below.high);
            }
        }
    }
    return found;
}
}  // namespace bullet_ccd
