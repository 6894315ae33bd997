/// Motion of a kinematic tree over a step: joint positions change linearly, q(t) = q0 + t * rate,
/// and the root moves rigidly; t in [0, 1].
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <span>
#include <vector>

namespace bullet_ccd
{
struct JointMotion
{
    RigidMotion root;               ///< of link 0
    std::vector<double> positions;  ///< at t = 0, one entry a link
    std::vector<double> rates;      ///< change over the step, one entry a link (mimic joints too)
};

/// The link at time t as seen from `base`: the frame of the query is that link's frame, or W if
/// `base` is kNone.
/// @pre base is kNone or an ancestor of `link` (or itself)
[[nodiscard]] MotionState linkStateAt(const KinematicTree& tree,
                                      const JointMotion& motion,
                                      std::int32_t base,
                                      std::int32_t link,
                                      double t);

/// Bound of the acceleration of points of the link relative to `base` over the whole step.
/// Sum over all pairs of joints between them, |q'_j| |q'_k| reach: the second derivative of a point
/// of a chain (bullet_ccd/README.md, "Motion bounds").
[[nodiscard]] AccelerationBound linkAccelerationBound(const KinematicTree& tree,
                                                      const JointMotion& motion,
                                                      std::int32_t base,
                                                      std::int32_t link);

/// Deepest link that is an ancestor of (or is) both.
[[nodiscard]] std::int32_t commonAncestor(const KinematicTree& tree,
                                          std::int32_t linkA,
                                          std::int32_t linkB);

/// True if a joint with a non-zero rate lies between `base` (exclusive) and `link` (inclusive), or
/// `base` is kNone and the root moves.
[[nodiscard]] bool moves(const KinematicTree& tree,
                         const JointMotion& motion,
                         std::int32_t base,
                         std::int32_t link);
}  // namespace bullet_ccd
