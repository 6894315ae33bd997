/// First contact among many pairs of moving bodies: the one loop behind all time-of-impact queries.
///
/// All pairs of all hierarchies wait in one heap, keyed by the time up to which each is certified
/// to be apart; only the earliest is looked at. A pair of nodes far apart for its size jumps ahead,
/// a near one is opened; the first pair of triangles that comes up within the tolerance is the
/// answer. So no pair is advanced beyond the first contact except by its own last step (temporal
/// culling), and a body that is never near costs one test (spatial culling).
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/motion/joint_motion.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/toi.h"

#include <memory>
#include <span>
#include <variant>

namespace bullet_ccd
{
class MovingFrames;
class PairMask;

/// One link of a moving kinematic tree.
struct LinkMotion
{
    const KinematicTree* tree = nullptr;
    const JointMotion* motion = nullptr;
    std::int32_t link = kNone;
    /// Of the tree and the motion, if the caller has them; else they are made.
    MovingFrames* frames = nullptr;
};

/// A hierarchy and how it moves.
struct MovingBody
{
    const SsvTree* tree = nullptr;
    std::variant<RigidMotion, LinkMotion, const UserMotion*> motion;
    /// Pose of the hierarchy's frame in the body (a Bullet compound child, a collider off its
    /// link).
    Eigen::Isometry3d X_BG = Eigen::Isometry3d::Identity();
};

/// Indices into the bodies of a query.
struct BodyPair
{
    std::int32_t bodyA = kNone;
    std::int32_t bodyB = kNone;
    const PairMask* mask = nullptr;  ///< triangles that are not tested against each other, or null
};

/// Scratch memory of a query; reusable, one per thread.
class BULLET_CCD_API ToiWorkspace
{
public:
    ToiWorkspace();
    ~ToiWorkspace();
    ToiWorkspace(ToiWorkspace&&) noexcept;
    ToiWorkspace& operator=(ToiWorkspace&&) noexcept;

    struct Scratch;
    [[nodiscard]] Scratch& scratch() { return *m_scratch; }

private:
    std::unique_ptr<Scratch> m_scratch;
};

struct FirstContactResult : ToiResult
{
    std::int32_t pair = kNone;      ///< index of the pair that touches (or overlaps) first
    bool startsTouching = false;    ///< some pair was within the tolerance at t = 0, but not below
    bool startsPressing = false;    ///< and closed in there
    bool mayStartTouching = false;  ///< true as well if that was not found out
};

/// First time at which one of `pairs` comes within the tolerance. The status is one of Separated,
/// Hit, Overlapping and IterationLimit.
///
/// Guarantee: no pair touches in [0, result.time); ToiStatus says what each outcome promises. Links
/// of one tree are compared in the frame of their deepest common ancestor, so that common motion
/// costs nothing. The answer does not depend on the order of pairs, except which of two
/// simultaneous contacts is named.
/// @param bodies every body's tree is non-null
/// @pre all motions are finite, options.tolerance > 0 (else throws std::invalid_argument)
[[nodiscard]] BULLET_CCD_API FirstContactResult firstContact(std::span<const MovingBody> bodies,
                                                             std::span<const BodyPair> pairs,
                                                             const ToiOptions& options,
                                                             ToiWorkspace& work);

/// Pose of the hierarchy of `body` in W at time t.
[[nodiscard]] BULLET_CCD_API Eigen::Isometry3d geometryPoseAt(const MovingBody& body, double t);
}  // namespace bullet_ccd
