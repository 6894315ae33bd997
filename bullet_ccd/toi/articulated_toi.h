/// First contact of a moving articulated body with its surroundings and with itself.
#pragma once

#include "bullet_ccd/toi/rigid_toi.h"

#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Links, their hierarchies and their motion.
struct ArticulatedBody
{
    const KinematicTree* tree = nullptr;
    /// One entry a link, in the link's frame; null for a link without geometry.
    std::span<const SsvTree* const> linkTrees;
    const JointMotion* motion = nullptr;
    /// Pairs of links that are tested against each other.
    std::span<const std::pair<std::int32_t, std::int32_t>> selfPairs;
};

/// One link's contact.
struct LinkContact
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;   ///< index into the obstacles, or kNone for self-collision
    std::int32_t otherLink = kNone;  ///< for self-collision
    double gap = 0.0;                ///< [m]
    Eigen::Vector3d pointLink = Eigen::Vector3d::Zero();   ///< on the link, in W [m]
    Eigen::Vector3d pointOther = Eigen::Vector3d::Zero();  ///< on the other, in W [m]
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from the link to the other, in W
};

struct ArticulatedToiResult
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// All pairs of links and obstacles within the tolerance at `time` that move relative to each
    /// other (the pairs that were closer at t = 0 only if they closed in further), the first
    /// contact first, then by (link, obstacle, otherLink). For Overlapping: the overlapping pair.
    std::vector<LinkContact> contacts;
    ToiCounters counters;
};

/// First time in [0, 1] at which a link comes within `options.tolerance` of an obstacle or of a
/// link that it is paired with. Pairs without relative motion are skipped. Throws
/// std::invalid_argument as rigidToi does, and where sizes of the spans do not match the tree.
[[nodiscard]] ArticulatedToiResult articulatedToi(const ArticulatedBody& body,
                                                  std::span<const RigidBody> obstacles,
                                                  const ToiOptions& options,
                                                  ToiWorkspace& work);
}  // namespace bullet_ccd
