/// The pairs of bodies of a query as the search sees them: relative motion, in batches for volumes
/// and in double precision for triangles.
#pragma once

#include "bullet_ccd/motion/moving_frames.h"
#include "bullet_ccd/toi/kernels/node_batch.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "bullet_ccd/toi/search/pair_step.h"
#include "bullet_ccd/toi/search/rigid_pair.h"
#include "bullet_ccd/toi/search/turn_profiles.h"
#include "bullet_ccd/toi/search/worth_trying.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// A pair of nodes of a pair of bodies, certified to keep its margin before `time`.
struct NodePair
{
    double time = 0.0;
    std::int32_t pair = kNone;
    std::int32_t nodeA = kNone;
    std::int32_t nodeB = kNone;
    float lastStep = 0.0F;  ///< that brought it to `time`
};

/// How one body of a pair moves.
struct PairSide
{
    const MovingBody* body = nullptr;
    MovingFrames* frames = nullptr;                       ///< of a link
    std::int32_t frame = kNone;                           ///< that the link is fixed to
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< of the tree in the frame or body
    AccelerationBound acceleration{};
    std::optional<AccelerationPlane> plane{};
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< from its origin to the tree's, in the
                                                       ///< axes of the tree
    bool rests = false;                                ///< in the frame of the query
    Eigen::Isometry3d X_atRest = Eigen::Isometry3d::Identity();  ///< of the tree there, if so
};

/// The body with which directions turn.
enum class TurningWith
{
    A,
    B
};

/// Two bodies of a query.
struct ScenePair
{
    const SsvTree* treeA = nullptr;
    const SsvTree* treeB = nullptr;
    const PairMask* mask = nullptr;
    bool sawTriangles = false;     ///< a pair of triangles was looked at
    std::int64_t untilTurn = 0;    ///< so many more pairs of nodes, then lookAtTurn()
    std::int32_t turning = kNone;  ///< index of the profiles, if there are any
    bool touchesAtStart = false;   ///< a pair of triangles is within the tolerance at t = 0
    bool startIsKnown = false;     ///< noteIfNear() found out whether they are
    PairLimits limits;
    double from = 0.0;  ///< the bodies can meet only between these two times (interval search)
    double until = 1.0;
    /// The whole bodies are apart along a face in [apartFrom, apartUntil].
    double apartFrom = 0.0;
    double apartUntil = 0.0;
    std::int64_t nextLook = 2000;  ///< at the whole bodies, after so many pairs of nodes
    double speedScale = 0.0;       ///< relative speed of any two points, to compare with sizes [m]

    bool isRigid = false;    ///< both move as RigidMotion does, and `rigid` holds
    bool inBatches = false;  ///< `poses` holds, too: eight poses at once
    RigidPair rigid{};
    RigidPoses poses{};

    std::int32_t base = 0;  ///< frame of a tree that is the frame of the query; 0: W
    /// Of rigid pairs only how they are fixed.
    PairSide sideA{};
    PairSide sideB{};
    /// Normal of a plane of all accelerations in the frame of the query, or zero.
    Eigen::Vector3d plane = Eigen::Vector3d::Zero();
    double acrossPlane = 0.0;  ///< see RelativeMotion
};

/// Invariant: motions and trees do not change during a query.
class PairScene
{
public:
    void reset(std::span<const MovingBody> bodies,
               std::span<const BodyPair> pairs,
               const ToiOptions& options);

    [[nodiscard]] std::int32_t size() const { return static_cast<std::int32_t>(m_pairs.size()); }
    [[nodiscard]] ScenePair& pair(std::int32_t index)
    {
        return m_pairs[static_cast<std::size_t>(index)];
    }
    [[nodiscard]] const ScenePair& pair(std::int32_t index) const
    {
        return m_pairs[static_cast<std::size_t>(index)];
    }
    [[nodiscard]] const SsvNode& nodeA(const NodePair& p) const
    {
        return nodeOf(treeA(p), p.nodeA);
    }
    [[nodiscard]] const SsvNode& nodeB(const NodePair& p) const
    {
        return nodeOf(treeB(p), p.nodeB);
    }

    /// Opens a node of one of the pair, see SsvTree::open().
    void open(const NodePair& p, bool ofA) const
    {
        ofA ? treeA(p).open(nodeA(p)) : treeB(p).open(nodeB(p));
    }

    /// To be called for a look at a pair of triangles.
    void noteTriangles(std::int32_t pair);

    /// True if what is below two nodes stays farther apart than the bodies may come, at any time,
    /// because they turn about one axis relative to each other.
    [[nodiscard]] bool neverMeets(const NodePair& p) const
    {
        const ScenePair& pair = m_pairs[static_cast<std::size_t>(p.pair)];
        return pair.turning != kNone && m_turning[static_cast<std::size_t>(pair.turning)].distance(
                                            p.nodeA, p.nodeB) > pair.limits.threshold;
    }

    /// True if the pair's mask exempts all that is below its nodes.
    [[nodiscard]] bool isExempt(const NodePair& p) const
    {
        const PairMask* mask = m_pairs[static_cast<std::size_t>(p.pair)].mask;
        return mask != nullptr && mask->exemptsNodes(p.nodeA, p.nodeB);
    }

    /// Certified steps of up to eight node pairs, each from its own time. They can be evaluated
    /// together if canShareBatch() says so of each with the first.
    void steps(std::span<const NodePair> nodePairs, ToiCounters& counters, float* out);
    [[nodiscard]] bool canShareBatch(const NodePair& p, const NodePair& first) const;

    /// True if a node pair that steps() looked at for t = 0 may be within the tolerance there,
    /// though it was certified to go on.
    [[nodiscard]] bool mayStartTouching() const { return m_mayStartTouching; }

    /// Relative state of a pair of bodies at time t; valid until the next call that names another.
    [[nodiscard]] const PairState& stateAt(std::int32_t pair, double t, ToiCounters& counters);

    /// The same with directions that turn with B, if the pair is rigid: what lies on a face of B
    /// stays apart along the normal of that face, however B turns.
    [[nodiscard]] const PairState& turningStateAt(std::int32_t pair,
                                                  double t,
                                                  ToiCounters& counters);

    /// Relative state with directions that turn with one of the bodies; with A, the roles of the
    /// two are swapped. Null where stateAt() has such directions, or bounds are too coarse.
    [[nodiscard]] const PairState* turnedStateAt(std::int32_t pair,
                                                 double t,
                                                 TurningWith with,
                                                 ToiCounters& counters);

    /// Frame of B's tree in W.
    [[nodiscard]] Eigen::Isometry3d worldOfB(std::int32_t pair, double t) const;

private:
    [[nodiscard]] static const SsvNode& nodeOf(const SsvTree& tree, std::int32_t index)
    {
        return tree.nodes()[static_cast<std::size_t>(index)];
    }
    [[nodiscard]] const SsvTree& treeA(const NodePair& p) const
    {
        return *m_pairs[static_cast<std::size_t>(p.pair)].treeA;
    }
    [[nodiscard]] const SsvTree& treeB(const NodePair& p) const
    {
        return *m_pairs[static_cast<std::size_t>(p.pair)].treeB;
    }
    [[nodiscard]] PairSide sideOf(const MovingBody& body);
    [[nodiscard]] MovingFrames& framesOf(const LinkMotion& link);
    [[nodiscard]] std::optional<std::array<MovingBody, 2>> asRigidBodies(
        const ScenePair& pair) const;
    void computeState(std::int32_t index, double t, PairState& state);
    void fillConstants(std::int32_t index);
    void fillLane(int lane, const NodePair& p, ToiCounters& counters);
    void spend(std::int32_t index, std::int64_t looks);
    void lookAtTurn(std::int32_t index);
    [[nodiscard]] float flatStepOf(const NodePair& p, float step, ToiCounters& counters);
    void lookAtWhole(std::int32_t index, double t, ToiCounters& counters);
    void lookAtFaces(std::span<const NodePair> nodePairs, ToiCounters& counters, float* out);

    std::span<const MovingBody> m_bodies;
    std::span<const BodyPair> m_bodyPairs;
    std::vector<ScenePair> m_pairs;
    /// Of trees whose bodies came without; the first `m_treesUsed` are in use.
    struct OwnFrames
    {
        const JointMotion* motion = nullptr;
        std::unique_ptr<MovingFrames> frames;
    };
    std::vector<OwnFrames> m_trees;
    std::size_t m_treesUsed = 0;
    /// The latest, of which the batch in hand and the triangles below it ask again.
    std::array<PairState, NodeBatch::kLanes> m_states;
    std::size_t m_latest = 0;
    /// Of the last pair that was asked for, in the frame of either body.
    struct Turned
    {
        RigidPair rigid{};
        PairState state;
        bool isUsable = false;
    };
    std::array<Turned, 2> m_turned;
    /// Of pairs that turn about one axis; the first `m_turningUsed` are in use.
    std::vector<TurningPair> m_turning;
    std::size_t m_turningUsed = 0;
    NodeBatch m_batch{};
    bool m_mayStartTouching = false;
    bool m_hasFaces = false;           ///< of some tree
    WorthTrying m_faces;               ///< steps along faces, in this query
    std::int32_t m_batchPair = kNone;  ///< whose constants fill all lanes of the batch
};
}  // namespace bullet_ccd
