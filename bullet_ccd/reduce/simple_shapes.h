/// Spheres, capsules and boxes around a mesh.
#pragma once

#include "bullet_ccd/reduce/reduce_mesh.h"

#include <array>

namespace bullet_ccd
{
/// Axes of the mesh (columns, right-handed) with the middle of its extents along them.
struct MeshFrame
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< extents about the middle [m]
};

/// The mesh's own axes, and the principal axes of its surface.
[[nodiscard]] std::array<MeshFrame, 2> meshFrames(const TriangleMesh& mesh);

// Models that contain all vertices, without their deviations.

[[nodiscard]] ReducedModel sphereAround(const TriangleMesh& mesh);
/// @param axis of the frame that the capsule lies along
[[nodiscard]] ReducedModel capsuleAround(const TriangleMesh& mesh,
                                         const MeshFrame& frame,
                                         int axis);
/// The frame's half extents must be positive.
[[nodiscard]] ReducedModel boxAround(const MeshFrame& frame);

/// Deviations of a capsule or sphere: those of its facets, which are outside of it, and of the
/// round surface. The bounds end early at `limit`.
void compareRound(const TriangleMesh& mesh,
                  const SsvTree& full,
                  double limit,
                  const StopCondition& stop,
                  ReducedModel& model);
}  // namespace bullet_ccd
