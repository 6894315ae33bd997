/// Motion of a kinematic tree over a step. Time t runs over [0, 1]. Joint positions change
/// linearly, q(t) = q0 + t * rate, and the root moves rigidly.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <span>
#include <vector>

namespace bullet_ccd
{
/// Motion of a spherical joint over the step: X_PL(t) = X_PL0 exp(t [rate]) start. The joint turns
/// about an axis at rest in the parent, at constant speed, by any number of revolutions.
struct BallMotion
{
    Eigen::Matrix3d start = Eigen::Matrix3d::Identity();  ///< rotation at t = 0
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();       ///< [rad per step], axes of X_PL0
};

/// The turn by the shortest arc from one rotation to another. The sense of a half turn is that of
/// motionBetween().
[[nodiscard]] BULLET_CCD_API BallMotion ballBetween(const Eigen::Matrix3d& start,
                                                    const Eigen::Matrix3d& end);

/// Motion of the root and of all joints.
struct JointMotion
{
    RigidMotion root;               ///< motion of link 0
    std::vector<double> positions;  ///< at t = 0, one entry per link
    std::vector<double> rates;      ///< change over the step, one entry per link (mimic joints too)
    /// One entry per link, used for spherical joints; may be empty if there are none.
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

/// Pose and velocity of the link at time t as seen from `base`: in that link's frame, or in W if
/// `base` is kNone.
/// @pre base is kNone or an ancestor of `link` (or itself)
[[nodiscard]] BULLET_CCD_API MotionState linkStateAt(const KinematicTree& tree,
                                                     const JointMotion& motion,
                                                     std::int32_t base,
                                                     std::int32_t link,
                                                     double t);

/// Bound of the acceleration of points of the link relative to `base`.
///
/// Guarantee: the bound holds at every time of the step.
/// Source: it is the sum of |q'_j| |q'_k| reach over all pairs of joints between the two, which
/// bounds the second derivative of a point of a chain (bullet_ccd/README.md, "Motion bounds").
[[nodiscard]] BULLET_CCD_API AccelerationBound linkAccelerationBound(const KinematicTree& tree,
                                                                     const JointMotion& motion,
                                                                     std::int32_t base,
                                                                     std::int32_t link);

/// The deepest link that is an ancestor of both links; a link counts as its own ancestor.
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
