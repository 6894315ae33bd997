/// Objects that one hand cannot hold, by formula: hollow, 0.3 m wide or more, in metres, z up,
/// resting on z = 0 and centred in x and y. Every object is one closed two-manifold surface.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <string>
#include <vector>

namespace bullet_ccd::shapes
{
/// Names of all of them.
[[nodiscard]] const std::vector<std::string>& largeObjectNames();

/// The object of that name. Throws std::invalid_argument for an unknown one.
[[nodiscard]] TriangleMesh makeLargeObject(const std::string& name);
}  // namespace bullet_ccd::shapes
