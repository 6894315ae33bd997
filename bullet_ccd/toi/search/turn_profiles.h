/// What a turn about one axis cannot bring nearer: how far from the axis, and how high along it,
/// the surfaces of two bodies reach.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// Where a surface is in cylindrical coordinates about the axis of a turn, which does not change
/// them.
struct TurnProfile
{
    Slab radius;  ///< distances from the axis [m]
    Slab height;  ///< along the axis [m]
};

/// Profiles of all nodes of a tree, exact for each triangle up to rounding. Allocates nothing once
/// `profiles` has held as many.
/// @param X_TG pose of the tree's frame in a frame T, whose z axis is the axis of the turn
/// @pre the tree is built to its end
void fillProfiles(const SsvTree& tree,
                  const Eigen::Isometry3d& X_TG,
                  std::vector<TurnProfile>& profiles);

/// Two trees that turn relative to each other about one axis, and do nothing else.
struct TurningPair
{
    std::array<std::vector<TurnProfile>, 2> profiles;  ///< of A and B
    double rounding = 0.0;                             ///< of a distance [m]

    /// A bound of the distance of what is below two nodes, whatever the angle [m].
    [[nodiscard]] double distance(std::int32_t nodeA, std::int32_t nodeB) const;
};
}  // namespace bullet_ccd
