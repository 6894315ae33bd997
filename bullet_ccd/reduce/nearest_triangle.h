/// The triangle of a hierarchy that is nearest to a point.
#pragma once

#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/reduce/reduce_mesh.h"

#include <limits>

namespace bullet_ccd
{
struct Nearest
{
    double distance = std::numeric_limits<double>::infinity();
    std::int32_t slot = kNone;
};

/// The triangle that is nearest to a point (tree's frame), or the one in the slot `guess` where
/// that is as near; or any that is within `enough` [m].
[[nodiscard]] Nearest nearestTriangle(const SsvTree& tree,
                                      const Eigen::Vector3d& point,
                                      std::int32_t guess,
                                      double enough = 0.0);

/// As surfaceDeviation() of one triangle in the tree's frame: bounds up to `near` need not be
/// better. `guess` is the slot of a triangle that may be near, and is so afterwards.
[[nodiscard]] Deviation triangleDeviation(const TriangleCorners& triangle,
                                          const SsvTree& other,
                                          double near,
                                          double limit,
                                          const StopCondition& stop,
                                          std::int32_t& guess);
}  // namespace bullet_ccd
