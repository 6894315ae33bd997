/// First contact of a moving articulated body with its surroundings and with itself.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_environment.h"
#include "bullet_ccd/toi/pair_mask.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Triangles of a link that are not tested against triangles of another link or an obstacle.
struct LinkMask
{
    std::int32_t link = kNone;
    std::int32_t otherLink = kNone;  ///< as in selfPairs, in that order; or
    std::int32_t obstacle = kNone;   ///< index into the obstacles
    const PairMask* mask = nullptr;  ///< A is the mesh of `link`
};

/// Links, their hierarchies and their motion.
struct ArticulatedBody
{
    const KinematicTree* tree = nullptr;
    /// One entry a link, in the link's frame; null for a link without geometry.
    std::span<const SsvTree* const> linkTrees;
    const JointMotion* motion = nullptr;
    /// Pairs of links that are tested against each other; see selfPairsOf().
    std::span<const std::pair<std::int32_t, std::int32_t>> selfPairs;
    std::span<const LinkMask> masks{};
};

/// All pairs of links with geometry that a joint lies between, but for the `disabled` ones (in any
/// order, as an SRDF lists them). Links that are joined directly are among them: they need a
/// LinkMask of the region of their joint (see maskNear) unless they are clear of each other.
[[nodiscard]] BULLET_CCD_API std::vector<std::pair<std::int32_t, std::int32_t>> selfPairsOf(
    const KinematicTree& tree,
    std::span<const SsvTree* const> linkTrees,
    std::span<const std::pair<std::int32_t, std::int32_t>> disabled = {});

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
    std::int32_t triangleLink = kNone;                 ///< closest triangles, in the meshes
    std::int32_t triangleOther = kNone;
    /// The joint, named by the link below it, that must stop for the link to stop: the nearest one
    /// above the link that moves, or above the other link if nothing above this one does. 0 for a
    /// root that moves; kNone if only the obstacle does.
    std::int32_t stopJoint = kNone;
    double time = 0.0;  ///< of the contact, in [0, 1]
};

/// What a query cost. Pairs are those of a link and an obstacle, or of two links, that move
/// relative to each other: pairs = culledBySpace + culledByTime + the rest.
struct ArticulatedCounters : ToiCounters
{
    std::int64_t pairs = 0;
    /// Never reached the hierarchies: the boxes that link and obstacle sweep are apart.
    std::int64_t culledBySpace = 0;
    /// Boxes meet, but the pair was certified beyond the answer before any of its triangles were
    /// looked at.
    std::int64_t culledByTime = 0;
    std::int64_t subdivisions = 0;  ///< intervals that were halved

    ArticulatedCounters& operator+=(const ArticulatedCounters& more)
    {
        nodePairs += more.nodePairs;
        trianglePairs += more.trianglePairs;
        states += more.states;
        pairs += more.pairs;
        culledBySpace += more.culledBySpace;
        culledByTime += more.culledByTime;
        subdivisions += more.subdivisions;
        return *this;
    }
};

struct ArticulatedToiResult
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// All pairs of links and obstacles within the tolerance at `time` that move relative to each
    /// other (the pairs that were closer at t = 0 only if they closed in further), the first
    /// contact first, then by (link, obstacle, otherLink). For Overlapping: the overlapping pair.
    std::vector<LinkContact> contacts;
    ArticulatedCounters counters;
};

/// Stages of a query can be switched off; the answer is the same, the cost is not.
struct ArticulatedToiOptions
{
    ToiOptions toi{};
    bool cullBySpace = true;  ///< boxes of the moving links, and trees over links and obstacles
    bool cullByTime = true;   ///< one queue for all pairs; else each pair is searched on its own
    bool subdivide = true;    ///< halve intervals over which links sweep wide boxes
    /// The others need obstacles that rest or move as RigidMotion, with the best-first strategy.
    MotionBound bound = MotionBound::SecondOrder;
};

/// First time in [0, 1] at which a link comes within `options.toi.tolerance` of an obstacle or of a
/// link that it is paired with. Pairs without relative motion are skipped.
///
/// Guarantee: as of rigidToi(), for all pairs (ToiStatus). Allocates nothing but the contacts of
/// the result once `work` is warm. Throws std::invalid_argument as rigidToi() does, and where sizes
/// of the spans do not match the tree.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
articulatedToi(const ArticulatedBody& body,
               const Environment& environment,
               const ArticulatedToiOptions& options,
               ToiWorkspace& work);

/// The same, for obstacles of one query: boxes over them are made here.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
articulatedToi(const ArticulatedBody& body,
               std::span<const RigidBody> obstacles,
               const ToiOptions& options,
               ToiWorkspace& work);
}  // namespace bullet_ccd
