/// First contact of a moving articulated body with its surroundings and with itself, and all
/// contacts of a motion in which joints stop one after the other.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Triangles of a link that are not tested against triangles of another link or an obstacle.
struct LinkMask
{
    std::int32_t link = kNone;
    std::int32_t otherLink = kNone;  ///< (link, otherLink) is one of selfPairs; or
    std::int32_t obstacle = kNone;   ///< index into the obstacles
    const PairMask* mask = nullptr;  ///< A is the mesh of `link`

    /// Whether it is that of the same pair.
    [[nodiscard]] bool isLike(const LinkMask& other) const
    {
        return link == other.link && otherLink == other.otherLink && obstacle == other.obstacle;
    }
};

/// Links, their hierarchies and their motion.
struct ArticulatedBody
{
    const KinematicTree* tree = nullptr;
    /// One entry per link, in the link's frame; null for a link without geometry.
    std::span<const SsvTree* const> linkTrees;
    const JointMotion* motion = nullptr;
    /// Pairs of links that are tested against each other; see selfPairsOf().
    std::span<const std::pair<std::int32_t, std::int32_t>> selfPairs;
    std::span<const LinkMask> masks{};

    /// The mask of the pair that `pair` names; null if there is none.
    [[nodiscard]] const PairMask* maskOf(const LinkMask& pair) const
    {
        const auto found =
            std::ranges::find_if(masks, [&](const LinkMask& each) { return each.isLike(pair); });
        return found != masks.end() ? found->mask : nullptr;
    }
};

/// All pairs of links that have geometry and a joint between them, except the `disabled` ones.
/// The order of the two links of a disabled pair does not matter. Links that are joined directly
/// are among the pairs: they need a LinkMask of the region of their joint (see maskNear()) unless
/// they are clear of each other.
[[nodiscard]] BULLET_CCD_API std::vector<std::pair<std::int32_t, std::int32_t>> selfPairsOf(
    const KinematicTree& tree,
    std::span<const SsvTree* const> linkTrees,
    std::span<const std::pair<std::int32_t, std::int32_t>> disabled = {});

/// The surroundings of an articulated body: a tree of boxes over objects, built once for any number
/// of queries. The objects rest or move as RigidBody says, over t in [0, 1]. Hierarchies and
/// motions supplied by the user are referred to and not copied. They must outlive the environment
/// and must not change while it is in use.
class BULLET_CCD_API Environment
{
public:
    /// One box of the tree. It has two children, of which the left one follows the node in the
    /// array, or up to kLeaf objects.
    struct Node
    {
        Eigen::AlignedBox3d box{};
        std::int32_t right = kNone;  ///< right child; kNone for a leaf
        std::int32_t first = 0;      ///< first object of a leaf, in order()
        std::int32_t count = 0;
    };
    static constexpr std::size_t kLeaf = 2;

    Environment() = default;
    explicit Environment(std::span<const RigidBody> bodies) { reset(bodies); }

    /// Replaces the objects, in O(n log n). Allocates nothing once it has held as many.
    /// Throws std::invalid_argument if a motion is not finite.
    void reset(std::span<const RigidBody> bodies);

    [[nodiscard]] std::span<const RigidBody> bodies() const { return m_bodies; }
    [[nodiscard]] bool moves(std::int32_t index) const
    {
        return m_moves[static_cast<std::size_t>(index)] != 0;
    }
    [[nodiscard]] std::size_t movingCount() const { return m_movingCount; }
    /// Bounds of an object over the whole step, in W [m].
    [[nodiscard]] const Eigen::AlignedBox3d& box(std::int32_t index) const
    {
        return m_boxes[static_cast<std::size_t>(index)];
    }
    /// Empty without objects; otherwise node 0 is the root.
    [[nodiscard]] std::span<const Node> nodes() const { return m_nodes; }
    [[nodiscard]] std::span<const std::int32_t> order() const { return m_order; }

private:
    void build(std::size_t begin, std::size_t end);

    std::vector<RigidBody> m_bodies;
    std::vector<std::uint8_t> m_moves;
    std::vector<Eigen::AlignedBox3d> m_boxes;
    std::vector<std::int32_t> m_order;
    std::vector<Node> m_nodes;
    std::size_t m_movingCount = 0;
};

/// A contact of a link with an obstacle or with another link.
struct LinkContact
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;   ///< index into the obstacles, or kNone for self-collision
    std::int32_t otherLink = kNone;  ///< for self-collision
    /// Distance of the named triangles [m]. Of a first contact, others of the pair may be nearer by
    /// the part of the tolerance that ToiOptions::aim leaves; with the default that is nothing.
    double gap = 0.0;
    Eigen::Vector3d pointLink = Eigen::Vector3d::Zero();   ///< on the link, in W [m]
    Eigen::Vector3d pointOther = Eigen::Vector3d::Zero();  ///< on the other, in W [m]
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from the link to the other, in W
    std::int32_t triangleLink = kNone;                 ///< closest triangles, in the meshes
    std::int32_t triangleOther = kNone;
    /// The joint, named by the link below it, that must stop for the link to stop. It is the
    /// nearest moving joint above the link, or above the other link if no joint above this one
    /// moves. It is 0 if the root moves, and kNone if only the obstacle moves.
    std::int32_t stopJoint = kNone;
    double time = 0.0;  ///< of the contact, in [0, 1]
};

/// What a query cost. A pair is a link and an obstacle, or two links, that move relative to each
/// other. Pairs that are not culled were searched down to their triangles.
struct ArticulatedCounters : ToiCounters
{
    std::int64_t pairs = 0;
    /// Pairs that never reached the hierarchies, because the boxes that both sweep are apart.
    std::int64_t culledBySpace = 0;
    /// Pairs whose boxes meet, but which were certified beyond the answer before any of their
    /// triangles were looked at.
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

/// First contact of an articulated body.
struct ArticulatedToiResult
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// All pairs within the tolerance at `time` that move relative to each other. Pairs that were
    /// closer at t = 0 are among them only if they closed in further. The first contact comes
    /// first; the others are ordered by (link, obstacle, otherLink). For Overlapping this is the
    /// overlapping pair.
    std::vector<LinkContact> contacts;
    ArticulatedCounters counters;
};

/// Stages of a query can be switched off. The answer stays the same, but the cost does not.
struct ArticulatedToiOptions
{
    ToiOptions toi{};
    bool cullBySpace = true;  ///< boxes of the moving links, and trees over links and obstacles
    bool cullByTime = true;   ///< one queue for all pairs; otherwise one search per pair
    bool subdivide = true;    ///< halve intervals over which links sweep wide boxes
    /// Only whether there is a contact is asked, as of a motion that a planner draws: the first
    /// that is found ends the query. Separated says what it always says. Else there is a contact at
    /// `time`, but perhaps an earlier one, too: nothing is certified before it, an overlap at the
    /// start may come back as a later Hit, and one pair is named, with its points only if the
    /// search met them. The strategy Interval makes use of it. It looks at some pairs before the
    /// search, which heeds `stop` but is not counted.
    bool anyContact = false;
};

/// First time in [0, 1] at which a link comes within `options.toi.tolerance` of an obstacle or of a
/// link that it is paired with. Pairs without relative motion are skipped.
///
/// Guarantee: no contact of any tested pair for t in [0, result.time); ToiStatus says what each
/// outcome promises. With `options.anyContact` that holds of Separated.
/// @param work scratch, reusable; one per thread
/// Throws std::invalid_argument as rigidToi() does, and if sizes of the spans do not match the
/// tree.
/// Allocates nothing but the contacts of the result once `work` is warm.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
articulatedToi(const ArticulatedBody& body,
               const Environment& environment,
               const ArticulatedToiOptions& options,
               ToiWorkspace& work);

/// The same for obstacles of a single query; the boxes over them are made here.
[[nodiscard]] BULLET_CCD_API ArticulatedToiResult
articulatedToi(const ArticulatedBody& body,
               std::span<const RigidBody> obstacles,
               const ToiOptions& options,
               ToiWorkspace& work);

/// Which joints stop at a contact.
enum class StopRule : std::uint8_t
{
    /// All joints from the link to the root stop, or, at a contact of two links, to their deepest
    /// common ancestor. So the link comes to rest. A finger whose second phalanx touches goes on
    /// with its last joint only.
    Chain,
    /// LinkContact::stopJoint alone stops. Joints nearer to the root go on, and the link with them.
    /// They stop at the next contact unless they carry the link away from this one or along it.
    NearestJoint,
};

struct ContactSequenceOptions
{
    ArticulatedToiOptions query{};
    StopRule rule = StopRule::Chain;
};

struct ContactSequence
{
    /// Hit if contacts were found, Separated if there were none. Overlapping, IterationLimit and
    /// Stopped end the sequence where they occur.
    ToiStatus status = ToiStatus::Separated;
    /// In the order of time. Each contact is listed once, with its time and the joint that had to
    /// stop.
    std::vector<LinkContact> contacts;
    /// When each joint stopped, in [0, 1], one entry per link; 1 if it went all the way.
    std::vector<double> stopTimes;
    JointMotion end;    ///< where the body ends: positions, balls and root; rates are zero
    double time = 1.0;  ///< up to which the motion is certified; 1 unless the sequence ended early
    ArticulatedCounters counters;  ///< of all queries
    int queries = 0;
};

/// Follows the motion of the body over [0, 1] through all its contacts.
///
/// At a contact the joints that the rule names stop where they are, together with the joints that
/// they drive or that drive them (mimic). A moving root stops with a chain. Pairs that are in
/// contact then are exempt as long as they separate, slide or rest on each other: pairs without
/// relative motion are not looked at, and the others must close in to three quarters of their
/// distance to count again. ToiOptions::aim is taken to be 1/2 to leave room for that, so every
/// query stops half a tolerance short. The sequence ends where an obstacle presses on and nothing
/// that can stop is left moving.
///
/// Guarantee: no contact at any time of the resulting motion, query by query as articulatedToi()
/// promises.
/// Throws std::invalid_argument as articulatedToi() does, and for obstacles with user motions,
/// which cannot be cut.
[[nodiscard]] BULLET_CCD_API ContactSequence
articulatedContacts(const ArticulatedBody& body,
                    std::span<const RigidBody> obstacles,
                    const ContactSequenceOptions& options,
                    ToiWorkspace& work);
}  // namespace bullet_ccd
