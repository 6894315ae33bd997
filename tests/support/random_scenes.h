/// Random pairs of small moving meshes, about half of which meet, and the contract that every
/// answer of a time-of-impact query has to meet.
#pragma once

#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/oracles/brute_force_toi.h"
#include "tests/support/random.h"
#include "tests/support/rigid_scene.h"

#include <string>

namespace bullet_ccd::tests
{
/// Soups, boxes and spheres of unit size that fly roughly at each other, turning up to a few times.
[[nodiscard]] RigidScene randomRigidScene(Random& random);

/// A mesh of unit size.
[[nodiscard]] TriangleMesh randomMesh(Random& random);

[[nodiscard]] ToiResult queryToi(const RigidScene& scene, double tolerance);
[[nodiscard]] ToiResult queryToi(const RigidScene& scene, const ToiOptions& options);

/// Rounding of a distance in that scene: 64 units in the last place of its largest coordinate.
[[nodiscard]] double roundingOf(const RigidScene& scene);

/// Expects what ToiStatus and ToiResult promise for `result`, by evaluating distances by brute
/// force at the reported time: gap, witnesses, normal.
void expectHonest(const RigidScene& scene,
                  const ToiResult& result,
                  double tolerance,
                  const std::string& what);
}  // namespace bullet_ccd::tests
