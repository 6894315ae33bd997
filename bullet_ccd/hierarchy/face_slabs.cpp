#include "bullet_ccd/hierarchy/face_slabs.h"

#include "bullet_ccd/hierarchy/ssv_node.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
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
}  // namespace

std::vector<Vector3d> largestNormals(std::span<const Corners> sample)
{
    std::map<Cell, Facing> facings;
    for (const Corners& c : sample)
    {
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
void include(Slab& slab, const Vector3d& normal, const Corners& corners)
{
    for (const Vector3d& corner : corners)
    {
        const double height = normal.dot(corner);
        slab.low = std::min(slab.low, height);
        slab.high = std::max(slab.high, height);
    }
}

void fillSlabs(std::span<const Vector3d> normals,
               std::span<const SsvNode> nodes,
               std::span<const Corners> corners,
               std::size_t begin,
               std::size_t end,
               std::span<Slab> slabs)
{
    const std::size_t count = normals.size();
    for (std::size_t i = end; i-- > begin;)  // children come after their parent
    {
        const SsvNode& node = nodes[i];
        for (std::size_t k = 0; k < count; ++k)
        {
            Slab slab = kNoSlab;
            if (node.isLeaf() && node.first != kNone)
            {
                include(slab, normals[k], corners[static_cast<std::size_t>(node.first)]);
            }
            for (std::int32_t child = 0; child < node.count; ++child)
            {
                const Slab& below = slabs[static_cast<std::size_t>(node.first + child) * count + k];
                slab.low = std::min(slab.low, below.low);
                slab.high = std::max(slab.high, below.high);
            }
            slabs[i * count + k] = slab;
        }
    }
}

FaceSlabs findFaceSlabs(std::span<const SsvNode> nodes, std::span<const Corners> corners)
{
    // A sample is enough: faces of few triangles cost little.
    const std::size_t stride = (corners.size() + kFaceSample - 1) / kFaceSample;
    std::vector<Corners> sample;
    for (std::size_t i = 0; i < corners.size(); i += stride)
    {
        sample.push_back(corners[i]);
    }
    FaceSlabs found{.normals = largestNormals(sample)};
    found.slabs.resize(found.normals.size() * nodes.size());
    fillSlabs(found.normals, nodes, corners, 0, nodes.size(), found.slabs);
    return found;
}
}  // namespace bullet_ccd
