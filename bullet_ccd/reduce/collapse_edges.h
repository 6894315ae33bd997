/// A mesh of fewer triangles, made edge by edge.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/stop_condition.h"

namespace bullet_ccd
{
/// Collapses edges of `start`, a mesh near the full one, as long as there is one that may be, those
/// first that change the surface least. One may be where points of the full mesh (vertices, middles
/// of edges and triangles) stay within `tolerance` [m] of the triangles around it, all points of
/// these within it of the full mesh, and no triangle turns over. So a place that allows no more
/// does not keep others from going on.
///
/// Closed meshes stay closed; where more than two triangles meet in an edge, it stays. That no
/// point of the full mesh is farther away is likely, and not certain: surfaceDeviation() tells.
/// Deterministic. Throws QueryStopped.
[[nodiscard]] TriangleMesh collapseEdges(const TriangleMesh& start,
                                         const SsvTree& full,
                                         double tolerance,
                                         const StopCondition& stop);
}  // namespace bullet_ccd
