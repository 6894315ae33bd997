/// The three strategies of firstContact(): how a query walks through the pairs of nodes.
#pragma once

#include "bullet_ccd/toi/model_use.h"
#include "bullet_ccd/toi/search/earliest_first.h"
#include "bullet_ccd/toi/search/pair_scene.h"

#include <algorithm>
#include <vector>

namespace bullet_ccd
{
/// Earliest contact found so far.
struct EarliestHit
{
    double time = 2.0;
    std::int32_t pair = kNone;
    std::int32_t triangleA = kNone;  ///< of the meshes
    std::int32_t triangleB = kNone;
    std::int32_t slotA = kNone;
    std::int32_t slotB = kNone;
    TriangleDistance distance{};  ///< points in B's tree
    double enough = 2.0;          ///< from here on to `time` these triangles are near enough
    bool atStart = false;         ///< the bodies touch where the query begins

    [[nodiscard]] bool found() const { return pair != kNone; }
};

/// Thrown inside a search, never out of firstContact().
struct GaveUp
{
    ToiStatus status = ToiStatus::IterationLimit;
    double time = 0.0;  ///< up to which all pairs are certified
    std::int32_t pair = kNone;
};

/// What is known of a pair of bodies that are within the tolerance of each other at t = 0.
struct TouchingStart
{
    bool touches = false;
    bool approaches = false;  ///< closest triangles of a touching pair close in at t = 0
};

/// Scratch and state of one query, shared by the strategies.
struct SearchState
{
    PairScene scene;
    EarliestFirst queue;          ///< best-first and C2A
    std::vector<NodePair> front;  ///< interval: pairs that wait, a block for every open interval
    std::vector<NodePair> work;   ///< interval: pairs to be looked at
    EarliestHit hit;
    TouchingStart start;
    double begin = 0.0;       ///< the search runs over [begin, end]; before it all is certified
    double end = 1.0;         ///< later than 0 or earlier than 1 for best-first only
    bool anyContact = false;  ///< interval: any hit ends the search
    bool inOrder = true;      ///< what has been looked at is all that there is before that time
    double certified = 0.0;   ///< all pairs keep their margin up to here
    ToiCounters counters;
    std::int64_t nextCheck = 0;  ///< after so many pairs the limits are looked at
    WorthTrying slides;          ///< steps of triangles that slide
    ToiOptions options;
    ModelUse* use = nullptr;  ///< of the caller, or null; stays from query to query

    /// Makes ready for a query.
    void reset(const ToiOptions& asked);
    [[nodiscard]] std::int64_t pairs() const { return counters.nodePairs + counters.trianglePairs; }
};

/// What checkLimit() does now and then.
void lookAtLimits(SearchState& state, double time, std::int32_t pair);

/// Throws GaveUp if the query has examined as many pairs as it may, or is to stop.
/// @param time up to which all pairs are certified
inline void checkLimit(SearchState& state, double time, std::int32_t pair)
{
    if (state.pairs() > state.nextCheck)
    {
        lookAtLimits(state, time, pair);
    }
}

/// Looks at two leaves at the pair's time. Returns true and moves the pair's time on if it goes on
/// from there; false if it cannot touch before the end, is exempt, or is in contact, which is then
/// noted in state.hit.
[[nodiscard]] bool advanceTriangles(SearchState& state, NodePair& p);

/// Looks at two leaves at the pair's time, which is certified for them. Returns true if their
/// triangles are near enough: a contact, which is then noted in state.hit.
[[nodiscard]] bool noteIfNear(SearchState& state, const NodePair& leaves);

/// Least width of a volume.
[[nodiscard]] inline float thickness(const SsvNode& node)
{
    return 2.0F * (std::min({node.half[0], node.half[1], node.half[2]}) + node.radius);
}

/// Walks from two nodes at the pair's time, which is certified for them, down to the triangles
/// where their volumes are nearest. Returns true if these are near enough: a contact, which is then
/// noted in state.hit, found without a look at the rest.
[[nodiscard]] bool findsContactBelow(SearchState& state, const NodePair& p);

/// The same, but only for volumes so flat that what they bound can hardly be farther apart than the
/// accuracy that is asked for. How thick a volume is says how far it deviates from a surface that
/// passes through it from end to end.
[[nodiscard]] inline bool meetsBelow(SearchState& state, const NodePair& p)
{
    const double room = state.scene.pair(p.pair).limits.room();
    return room > 0.0 && p.time > 0.0 &&
           static_cast<double>(thickness(state.scene.nodeA(p)) + thickness(state.scene.nodeB(p))) <=
               room &&
           findsContactBelow(state, p);
}

/// True if the bodies of the contact that was found are within the tolerance at t = 0 already, and
/// close in there: the triangles that meet, or those that are closest then.
[[nodiscard]] bool pressesFromStart(SearchState& state);

/// Moves the contact that was found back to a time from `state.hit.enough` on.
void moveHit(SearchState& state, double time);

/// The node pairs that the children of the larger node of `p` make, at the time of `p`. The node
/// must be opened (PairScene::open()) before they are looked at.
struct Opening
{
    bool openA = false;
    std::int32_t first = kNone;
    std::int32_t count = 0;  ///< at most kArity

    Opening(const SsvNode& a, const SsvNode& b)
        : openA(b.isLeaf() || (!a.isLeaf() && a.size() >= b.size()))
    {
        const SsvNode& opened = openA ? a : b;
        first = opened.first;
        count = opened.count;
    }

    [[nodiscard]] NodePair child(NodePair p, std::int32_t k) const
    {
        (openA ? p.nodeA : p.nodeB) = first + k;
        return p;
    }
};

/// Throws std::invalid_argument for options that make no sense.
void checkOptions(const ToiOptions& options);

/// The strategy of state.options over the pairs of the scene.
void searchScene(SearchState& state);

/// state.hit, which was found, in W.
[[nodiscard]] FirstContactResult describeHit(SearchState& state);

// Each fills state.hit with the first contact, if there is one in [0, 1].
void searchBestFirst(SearchState& state);
void searchIntervals(SearchState& state);
/// The same from the node pairs of state.front on, each certified up to its own time, and all up to
/// `begin`.
void searchIntervalsFrom(SearchState& state, double begin);
void searchC2A(SearchState& state);
}  // namespace bullet_ccd
