/// Objects for two hands, by formula: 0.3 m wide or more, in metres, z up, resting on z = 0 and
/// centred in x and y. Every object is one closed two-manifold surface. Twelve are shells with a
/// vent of 4 mm at their top, convex and at least 0.25 m across, so that no hand of usual size
/// finds anything to close about. A pot and a tray are open, with rims of a centimetre.
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
