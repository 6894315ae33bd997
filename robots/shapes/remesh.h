/// Improves a closed mesh of a solid's surface; see polygonize.h.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "robots/shapes/polygonize.h"

namespace bullet_ccd::shapes
{
/// Coarsens and evens out `mesh`, which must be closed, two-manifold and finer than wanted.
[[nodiscard]] TriangleMesh remesh(const TriangleMesh& mesh,
                                  const Solid& solid,
                                  const PolygonizeOptions& options);
}  // namespace bullet_ccd::shapes
