/// Convex hull of the vertices of a mesh, by Qhull.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

namespace bullet_ccd
{
/// Closed and wound outwards; without triangles if the vertices are in a plane, or so nearly that
/// Qhull sees no solid. Vertices of the hull are vertices of the mesh.
[[nodiscard]] TriangleMesh convexHull(const TriangleMesh& mesh);
}  // namespace bullet_ccd
