/// First contact of moving bodies: of two rigid bodies, or among many pairs of bodies of all kinds.
///
/// One loop is behind all time-of-impact queries. All pairs of nodes wait in one heap. Its key is
/// the time up to which a pair is certified to be apart, and only the earliest pair is looked at. A
/// pair of nodes that is far apart for its size jumps ahead; a near one is opened. The first pair
/// of triangles that comes up within the tolerance is the answer. So no pair is advanced beyond the
/// first contact except by its own last step (temporal culling), and a body that is never near
/// costs one test (spatial culling).
#pragma once

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/toi.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

namespace bullet_ccd
{
class MovingFrames;

/// A hierarchy in the body frame and the body's motion X_W(t), t in [0, 1].
struct RigidBody
{
    const SsvTree* tree = nullptr;
    RigidMotion motion{};
    const UserMotion* userMotion = nullptr;  ///< if not null, in place of `motion`
};

/// First time in [0, 1] at which two rigidly moving meshes come within `options.tolerance`.
///
/// Guarantee: no contact for t in [0, result.time); ToiStatus says what each outcome promises.
/// @param options tolerance [m], minimum separation [m], iteration limit, deadline
/// @param work    scratch, reusable; one per thread
/// Throws std::invalid_argument for motions that are not finite or a tolerance that is not
/// positive.
[[nodiscard]] BULLET_CCD_API ToiResult rigidToi(const RigidBody& bodyA,
                                                const RigidBody& bodyB,
                                                const ToiOptions& options,
                                                ToiWorkspace& work);

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

/// The body as firstContact() takes it.
[[nodiscard]] BULLET_CCD_API MovingBody movingBody(const RigidBody& body);

/// Triangles of two meshes that are not tested against each other, because two links are joined
/// there or a body rests on another from the start. A pair of triangles is exempt if both are
/// marked. Unmarked triangles are tested against all others.
class BULLET_CCD_API PairMask
{
public:
    /// @param marksA,marksB one entry per triangle of the mesh; non-zero marks it
    PairMask(const SsvTree& treeA,
             const SsvTree& treeB,
             std::span<const std::uint8_t> marksA,
             std::span<const std::uint8_t> marksB);

    /// True if all triangles below one node are exempt from all below the other.
    [[nodiscard]] bool exemptsNodes(std::int32_t nodeA, std::int32_t nodeB) const
    {
        return m_nodesA[static_cast<std::size_t>(nodeA)] != 0 &&
               m_nodesB[static_cast<std::size_t>(nodeB)] != 0;
    }
    /// True if the two triangles, given by their indices in the meshes, are exempt.
    [[nodiscard]] bool exemptsTriangles(std::int32_t triangleA, std::int32_t triangleB) const
    {
        return m_marksA[static_cast<std::size_t>(triangleA)] != 0 &&
               m_marksB[static_cast<std::size_t>(triangleB)] != 0;
    }
    /// The marks of the triangles.
    [[nodiscard]] std::span<const std::uint8_t> marksA() const { return m_marksA; }
    [[nodiscard]] std::span<const std::uint8_t> marksB() const { return m_marksB; }
    /// The marks of the nodes, as treeDistance() takes them.
    [[nodiscard]] NodeMarks nodeMarks() const { return {.a = m_nodesA, .b = m_nodesB}; }
    /// True if no pair is exempt.
    [[nodiscard]] bool isEmpty() const { return m_isEmpty; }

private:
    std::vector<std::uint8_t> m_marksA;
    std::vector<std::uint8_t> m_marksB;
    std::vector<std::uint8_t> m_nodesA;
    std::vector<std::uint8_t> m_nodesB;
    bool m_isEmpty = true;
};

/// Marks on both meshes the triangles that are within `reach` [m] of the other mesh at one of the
/// poses. For two joined links, poses over the range of the joint mark the region of the joint, and
/// the rest of both links is still tested.
/// @param posesOfAInB poses X_BA of A's frame in B's
[[nodiscard]] BULLET_CCD_API PairMask maskNear(const SsvTree& treeA,
                                               const SsvTree& treeB,
                                               std::span<const Eigen::Isometry3d> posesOfAInB,
                                               double reach);

/// A pair of bodies that a query tests, as indices into its bodies.
struct BodyPair
{
    std::int32_t bodyA = kNone;
    std::int32_t bodyB = kNone;
    const PairMask* mask = nullptr;  ///< triangles that are not tested against each other, or null
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
/// Separated, Hit, Overlapping, IterationLimit and Stopped.
///
/// Guarantee: no contact of any pair for t in [0, result.time); ToiStatus says what each outcome
/// promises. The answer does not depend on the order of the pairs, except which of two simultaneous
/// contacts is named. Links of one tree are compared in the frame of their deepest common ancestor,
/// so common motion costs nothing.
/// @param options tolerance [m], minimum separation [m], iteration limit, deadline
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
