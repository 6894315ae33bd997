/// Pairs of triangles that may be near each other. Internal to appendContacts().
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <cstdint>
#include <utility>
#include <vector>

namespace bullet_ccd
{
using IndexPairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

/// Sets `slots` to all pairs of triangles, by their slots, whose volumes are at most `threshold`
/// apart, and to some that are farther. Deterministic order.
/// @param R, p pose of A's tree frame in that of B's tree
/// @param open scratch
void collectNearSlots(const SsvTree& treeA,
                      const SsvTree& treeB,
                      const Eigen::Matrix3d& R,
                      const Eigen::Vector3d& p,
                      double threshold,
                      IndexPairs& open,
                      IndexPairs& slots);
}  // namespace bullet_ccd
