/// Seeded query sets that need no file but the meshes.
#pragma once

#include "benchmarks/rigid/rigid_sets.h"

namespace bullet_ccd::benchmarks
{
/// See makeRigidSet().
[[nodiscard]] RigidSet generateSet(const std::string& name,
                                   MeshLibrary& meshes,
                                   std::uint64_t seedShift);
}  // namespace bullet_ccd::benchmarks
