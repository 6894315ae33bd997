/// Motion of a kinematic tree over a step: joint positions change linearly, q(t) = q0 + t * rate,
/// and the root moves rigidly; t in [0, 1].
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <span>
#include <vector>

namespace bullet_ccd
{
/// A spherical joint over the step: X_PL(t) = X_PL0 exp(t [rate]) start. One turn about an axis at
/// rest in the parent, at constant speed, by any number of revolutions.
struct BallMotion
{
    Eigen::Matrix3d start = Eigen::Matrix3d::Identity();  ///< rotation at t = 0
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();       ///< [rad per step], axes of X_PL0
};

/// The turn by the shortest arc from one rotation to another; half turns as in motionBetween().
[[nodiscard]] BULLET_CCD_API BallMotion ballBetween(const Eigen::Matrix3d& start,
                                                    const Eigen::Matrix3d& end);

struct JointMotion
{
    RigidMotion root;               ///< of link 0
    std::vector<double> positions;  ///< at t = 0, one entry a link
    std::vector<double> rates;      ///< change over the step, one entry a link (mimic joints too)
    /// One entry a link, used for spherical joints; may be empty if there are none.
    std::vector<BallMotion> balls{};

    /// @pre the joint above `link` is spherical
    [[nodiscard]] const BallMotion& ball(std::int32_t link) const
    {
        return balls[static_cast<std::size_t>(link)];
    }
};

/// The part of the motion from `begin` to `end` as a motion over [0, 1].
[[nodiscard]] BULLET_CCD_API JointMotion partOf(const JointMotion& motion,
                                                double begin,
                                                double end);

/// The link at time t as seen from `base`: the frame of the query is that link's frame, or W if
/// `base` is kNone.
/// @pre base is kNone or an ancestor of `link` (or itself)
[[nodiscard]] BULLET_CCD_API MotionState linkStateAt(const KinematicTree& tree,
                                                     const JointMotion& motion,
                                                     std::int32_t base,
                                                     std::int32_t link,
                                                     double t);

/// Bound of the acceleration of points of the link relative to `base` over the whole step.
/// Sum over all pairs of joints between them, |q'_j| |q'_k| reach: the second derivative of a point
/// of a chain (bullet_ccd/README.md, "Motion bounds").
[[nodiscard]] BULLET_CCD_API AccelerationBound linkAccelerationBound(const KinematicTree& tree,
                                                                     const JointMotion& motion,
                                                                     std::int32_t base,
                                                                     std::int32_t link);

/// Deepest link that is an ancestor of (or is) both.
[[nodiscard]] BULLET_CCD_API std::int32_t commonAncestor(const KinematicTree& tree,
                                                         std::int32_t linkA,
                                                         std::int32_t linkB);

/// True if a joint with a non-zero rate lies between `base` (exclusive) and `link` (inclusive), or
/// `base` is kNone and the root moves.
[[nodiscard]] BULLET_CCD_API bool moves(const KinematicTree& tree,
                                        const JointMotion& motion,
                                        std::int32_t base,
                                        std::int32_t link);
}  // namespace bullet_ccd
