/// Distance of two triangles that do not cross, in double precision: fast, and good for a
/// direction.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"

#include <array>

namespace bullet_ccd::reference
{
/// The closest of all edge-edge and corner-face pairs; crossing triangles have a positive result.
[[nodiscard]] InstantDistance closestFeatures(const std::array<Eigen::Vector3d, 3>& a,
                                              const std::array<Eigen::Vector3d, 3>& b);
}  // namespace bullet_ccd::reference
