/// How time, memory, build time and file times grow with the number of triangles.
#pragma once

#include "benchmarks/rigid/rigid_run.h"

namespace bullet_ccd::benchmarks
{
/// Prints a table for knots and bumpy spheres of 1K to 1M triangles, the same motions at all sizes.
/// @param isQuick small meshes only
/// @return its rows, "wrong" among their values
[[nodiscard]] nlohmann::json printGrowth(MeshLibrary& meshes,
                                         const RunOptions& options,
                                         bool isQuick);
/// Bytes of a hierarchy: nodes, triangles in their order, mesh.
[[nodiscard]] double bytesOf(const SsvTree& tree);
/// Wall time of building it [ms], the median of some.
[[nodiscard]] double buildMilliseconds(const TriangleMesh& mesh, VolumeKind kind);
}  // namespace bullet_ccd::benchmarks
