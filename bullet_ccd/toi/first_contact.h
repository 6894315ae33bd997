/// First contact among many pairs of moving bodies: the one loop behind all time-of-impact queries.
///
/// All pairs of nodes wait in one heap. Its key is the time up to which a pair is certified to be
/// apart, and only the earliest pair is looked at. A pair of nodes that is far apart for its size
/// jumps ahead; a near one is opened. The first pair of triangles that comes up within the
/// tolerance is the answer. So no pair is advanced beyond the first contact except by its own last
/// step (temporal culling), and a body that is never near costs one test (spatial culling).
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
    /// Frames of the tree and the motion, if the caller has them; otherwise they are made.
    MovingFrames* frames = nullptr;
};

/// A hierarchy and how it moves.
struct MovingBody
{
    const SsvTree* tree = nullptr;
    std::variant<RigidMotion, LinkMotion, const UserMotion*> motion;
    /// Pose of the hierarchy's frame in the body, for instance of a child of a Bullet compound.
    Eigen::Isometry3d X_BG = Eigen::Isometry3d::Identity();
};

/// A pair of bodies that a query tests, as indices into its bodies.
struct BodyPair
{
    std::int32_t bodyA = kNone;
    std::int32_t bodyB = kNone;
    const PairMask* mask = nullptr;  ///< triangles that are not tested against each other, or null
};

/// Scratch memory of queries. It is reusable; use one per thread.
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

/// First contact among many pairs.
struct FirstContactResult : ToiResult
{
    std::int32_t pair = kNone;      ///< index of the pair that touches (or overlaps) first
    bool startsTouching = false;    ///< some pair was in contact at t = 0, but did not overlap
    bool startsPressing = false;    ///< such a pair also closed in at t = 0
    bool mayStartTouching = false;  ///< also true if the query did not find out
};

/// First time in [0, 1] at which one of `pairs` comes within the tolerance. The status is one of
/// Separated, Hit, Overlapping and IterationLimit.
///
/// Guarantee: no contact of any pair for t in [0, result.time); ToiStatus says what each outcome
/// promises. The answer does not depend on the order of the pairs, except which of two simultaneous
/// contacts is named. Links of one tree are compared in the frame of their deepest common ancestor,
/// so common motion costs nothing.
/// @param options tolerance [m], minimum separation [m], iteration limit
/// @param work    scratch, reusable; one per thread
/// @pre  the tree of every body is non-null
/// Throws std::invalid_argument for motions that are not finite or a tolerance that is not
/// positive.
[[nodiscard]] BULLET_CCD_API FirstContactResult firstContact(std::span<const MovingBody> bodies,
                                                             std::span<const BodyPair> pairs,
                                                             const ToiOptions& options,
                                                             ToiWorkspace& work);

/// Pose of the hierarchy of `body` in W at time t.
[[nodiscard]] BULLET_CCD_API Eigen::Isometry3d geometryPoseAt(const MovingBody& body, double t);
}  // namespace bullet_ccd
