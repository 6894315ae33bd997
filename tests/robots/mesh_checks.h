/// Checks of generated meshes that several tests share.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <vector>

namespace bullet_ccd::tests
{
/// Least ratio of area to squared longest edge over all triangles; sqrt(3)/4 if all are
/// equilateral.
[[nodiscard]] inline double worstShape(const TriangleMesh& mesh)
{
    double worst = 1.0;
    for (const auto& [i, j, k] : mesh.triangles)
    {
        const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(i)];
        const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(j)];
        const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(k)];
        const double longest =
            std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
        worst = std::min(worst, 0.5 * (b - a).cross(c - a).norm() / longest);
    }
    return worst;
}

/// V - E + F of a watertight mesh: 2 for a ball, 0 with one handle.
[[nodiscard]] inline std::int64_t eulerCharacteristic(const TriangleMesh& mesh)
{
    const auto faces = static_cast<std::int64_t>(mesh.triangles.size());
    return static_cast<std::int64_t>(mesh.vertices.size()) - faces / 2;
}

/// True if the triangles around every vertex form one fan (edges alone do not forbid two cones that
/// share their tip). `mesh` is watertight.
[[nodiscard]] inline bool everyVertexHasOneFan(const TriangleMesh& mesh)
{
    std::vector<std::map<std::int32_t, std::int32_t>> next(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t i = 0; i < 3; ++i)
        {
            next[static_cast<std::size_t>(t[i])][t[(i + 1) % 3]] = t[(i + 2) % 3];
        }
    }
    return std::ranges::all_of(next,
                               [](const auto& ring)
                               {
                                   std::size_t steps = 0;
                                   std::int32_t at = ring.empty() ? 0 : ring.begin()->first;
                                   do
                                   {
                                       at = ring.empty() ? 0 : ring.at(at);
                                       ++steps;
                                   } while (!ring.empty() && at != ring.begin()->first);
                                   return steps == ring.size();
                               });
}
}  // namespace bullet_ccd::tests
