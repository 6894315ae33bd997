/// What a mesh file holds before it is a triangle mesh: polygons of any number of corners.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace bullet_ccd
{
struct PolygonSoup
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<std::int32_t> corners;     ///< of all polygons, one after the other
    std::vector<std::size_t> polygonEnds;  ///< index into `corners` behind the last corner of each
    std::int64_t droppedElements = 0;      ///< lines and points
};

/// Triangulates: triangles are taken over, a larger polygon is cut by ear clipping in the plane of
/// its area vector, so that simple concave polygons come out right. Polygons that have no such
/// plane, or intersect themselves, become fans. A corner that is no vertex throws
/// std::runtime_error starting with `name`.
[[nodiscard]] BULLET_CCD_API TriangleMesh triangulate(PolygonSoup soup, const std::string& name);
}  // namespace bullet_ccd
