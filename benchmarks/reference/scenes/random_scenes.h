/// Random pairs of small moving meshes, about half of which meet.
#pragma once

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/rigid_scene.h"
#include "bullet_ccd/toi/rigid_toi.h"

namespace bullet_ccd::reference
{
/// Soups, boxes and spheres of unit size that fly roughly at each other, turning up to a few times.
[[nodiscard]] RigidScene randomRigidScene(Random& random);

/// A mesh of unit size.
[[nodiscard]] TriangleMesh randomMesh(Random& random);

[[nodiscard]] ToiResult queryToi(const RigidScene& scene, double tolerance);
[[nodiscard]] ToiResult queryToi(const RigidScene& scene, const ToiOptions& options);

/// Rounding of a distance in that scene: 64 units in the last place of its largest coordinate.
[[nodiscard]] double roundingOf(const RigidScene& scene);
}  // namespace bullet_ccd::reference
