/// Winding number of a closed surface about points, by counting crossings of a ray.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/check/box_grid.h"

#include <vector>

namespace bullet_ccd::grasp
{
class ClosedSurface
{
public:
    /// Refers to `mesh`, which must be watertight and outlive this.
    explicit ClosedSurface(const TriangleMesh& mesh) : m_mesh(&mesh) {}

    /// True if the surface winds around the point; false on the surface itself (up to rounding).
    /// Not for several threads at a time: what a ray direction needs is prepared at its first use.
    [[nodiscard]] BULLET_CCD_API bool contains(const Eigen::Vector3d& point);

    /// Distance of a point from the surface [m]; looks at all triangles.
    [[nodiscard]] double distance(const Eigen::Vector3d& point) const;

private:
    /// The mesh turned so that the rays run along +z, and a grid over its shadow on z = 0.
    struct Turned
    {
        Eigen::Matrix3d turn;
        std::vector<Eigen::Vector3d> vertices;
        BoxGrid shadow;
    };
    [[nodiscard]] Turned turned(const Eigen::Vector3d& rayDirection) const;

    const TriangleMesh* m_mesh;
    std::vector<Turned> m_turned;
    std::vector<std::int32_t> m_found;
};
}  // namespace bullet_ccd::grasp
