/// Checks answers of rigidToi() before anything is timed.
#pragma once

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/toi/toi.h"

#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Who judges the answers: FCL, or our own exact distance where it is not asked.
struct Judges
{
    const SsvTree& treeA;
    const SsvTree& treeB;
    const FclModel* modelA = nullptr;
    const FclModel* modelB = nullptr;
    std::span<const FclAnswer> naive{};  ///< FCL's samples: one entry per query
};

struct CheckResult
{
    int hits = 0;       ///< queries that are known to collide
    int missed = 0;     ///< ends without contact on one of these
    int late = 0;       ///< reported after the surfaces meet
    int falseHits = 0;  ///< reported at a distance above the tolerance
    int badGaps = 0;  ///< the gap at the time (hits) or over the motion (others) is not as reported
    int early = 0;    ///< before the reference itself was within the tolerance
    int gaveUp = 0;   ///< iteration limit
    std::vector<double> errors;           ///< true minus reported time, of hits found
    std::vector<std::string> complaints;  ///< one line a wrong answer

    [[nodiscard]] int wrong() const { return missed + late + falseHits + badGaps + early + gaveUp; }
};

/// File sets: against their references. Others: against the peer's first overlapping sample, which
/// is an upper bound of the time of contact, and a bisection from the reported time. All: against
/// exact distances.
[[nodiscard]] CheckResult checkAnswers(const RigidSet& set,
                                       std::span<const ToiResult> answers,
                                       double tolerance,
                                       const Judges& judges);
}  // namespace bullet_ccd::benchmarks
