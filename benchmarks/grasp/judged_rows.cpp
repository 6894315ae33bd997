#include "benchmarks/grasp/judged_rows.h"

#include "benchmarks/closing/discrete_closing.h"
#include "benchmarks/grasp/closing_verdict.h"
#include "benchmarks/support/timing.h"
#include "grasp/approach/approach.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/closing/closing.h"
#include "grasp/sim/hand_simulation.h"
#include "tools/grasp_cli/plan/plan_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::ClosingResult;
using nlohmann::json;
using tools::LoadedHand;
using tools::LoadedObject;

constexpr double kFineStep = 0.001;  // [s], at 1 rad/s

/// Counts over the closings of a pair.
struct ClosingCounts
{
    int candidates = 0;
    int closings = 0;  // that began, free of overlaps
    int inside = 0;    // ours, at the end
    int referenceInside = 0;
    double largestGap = 0.0;         // ours [m]
    double largestDifference = 0.0;  // [rad]
    std::array<int, kClosingVerdicts> verdicts{};
    std::vector<int> unexplained;  // numbers of the candidates
    double seconds = 0.0;          // approach and closing of ours, in all

    [[nodiscard]] json row() const
    {
        json verdictCounts;
        for (int i = 0; i < kClosingVerdicts; ++i)
        {
            verdictCounts[toString(static_cast<ClosingVerdict>(i))] =
                verdicts[static_cast<std::size_t>(i)];
        }
        return {{"candidates", candidates},
                {"closings", closings},
                {"inside", inside},
                {"reference_inside", referenceInside},
                {"largest_gap_m", largestGap},
                {"largest_difference_rad", largestDifference},
                {"verdicts", verdictCounts},
                {"unexplained", unexplained},
                {"seconds", seconds}};
    }
};

void count(ClosingCounts& counts,
           int number,
           const PosedClosing& start,
           const ClosingResult& ours,
           const ClosingResult& other,
           const ClosingLikeness& likeness)
{
    ++counts.closings;
    counts.inside += isInside(start, ours.positions) ? 1 : 0;
    counts.referenceInside += isInside(start, other.positions) ? 1 : 0;
    counts.largestGap = std::max(counts.largestGap, largestStopGap(start, ours));
    counts.largestDifference = std::max(
        counts.largestDifference, postureDifference(start.hand, ours.positions, other.positions));
    const ClosingVerdict verdict = compareClosings(start, ours, other, likeness);
    ++counts.verdicts[static_cast<std::size_t>(verdict)];
    if (verdict == ClosingVerdict::Unexplained)
    {
        counts.unexplained.push_back(number);
    }
}

bool began(const ClosingResult& closing)
{
    return closing.status == ToiStatus::Hit || closing.status == ToiStatus::Separated;
}

json named(json row, const LoadedHand& hand, const LoadedObject& object)
{
    row["hand"] = hand.file.stem().string();
    row["object"] = object.object.name;
    return row;
}
}  // namespace

const char* toString(ClosingReference reference)
{
    constexpr std::array<const char*, 3> kNames{"sweep", "simulated", "full"};
    return kNames[static_cast<std::size_t>(reference)];
}

json judgeClosings(const LoadedHand& hand,
                   const LoadedObject& object,
                   ClosingReference reference,
                   const grasp::PlannerOptions& options)
{
    const bool sweep = reference == ClosingReference::Sweep;
    const bool full = reference == ClosingReference::Full;
    // Another accuracy may well end in another posture.
    const ClosingLikeness likeness{.angle = full    ? INFINITY
                                            : sweep ? 0.02
                                                    : 0.01,
                                   .sameLinks = reference == ClosingReference::Simulated,
                                   .reach = options.closing.contactThreshold};
    const grasp::CloseHand close = grasp::kinematicClosing();
    const std::unique_ptr<LinkProximity> trees = treeProximity(hand.hand, object.object);
    const double tolerance = options.closing.tolerance;
    grasp::ClosingOptions ofReference = options.closing;
    ofReference.tolerance = full ? kDefaultTolerance : tolerance;
    const grasp::CloseHand closeReference = full ? grasp::kinematicClosing()
                                            : sweep
                                                ? discreteEngine(*trees,
                                                                 {.closingStep = kFineStep,
                                                                  .contactGap = tolerance,
                                                                  .contactLayer = 2.0 * tolerance,
                                                                  .maxSteps = 1'000'000})
                                                : grasp::simulatedClosing()();
    const std::array bodies{RigidBody{.tree = &object.object.tree, .motion = {}}};
    const Environment environment(bodies);
    const grasp::ApproachShapes shapes = grasp::approachShapes(hand.hand, object.object);
    grasp::PenetrationCheck check(hand.hand, object.object);
    ToiWorkspace work;
    ClosingCounts counts;
    for (int number = 0; number < options.candidates; ++number)
    {
        ++counts.candidates;
        const grasp::ApproachCandidate candidate = grasp::sampleApproach(hand.hand,
                                                                         object.object,
                                                                         shapes,
                                                                         options.seed,
                                                                         number,
                                                                         options.candidates,
                                                                         options.approach);
        PosedClosing start{.hand = hand.hand,
                           .object = object.object,
                           .check = check,
                           .X_WH = candidate.X_WStart,
                           .open = hand.hand.preshapes[candidate.preshape].positions};
        const Eigen::Vector3d shift = candidate.distance * candidate.direction_W;
        ArticulatedToiResult found;
        ClosingResult ours;
        const double micros = wallMicrosecondsOf(
            [&]
            {
                found = grasp::approachUntilContact(hand.hand,
                                                    environment,
                                                    start.X_WH,
                                                    start.open,
                                                    shift,
                                                    options.closing.tolerance,
                                                    work);
                if (found.status == ToiStatus::Hit)
                {
                    start.X_WH.translation() += found.time * shift;
                    ours = close(hand.hand, object.object, start.X_WH, start.open, options.closing);
                }
            });
        if (found.status != ToiStatus::Hit)
        {
            continue;
        }
        counts.seconds += 1e-6 * micros;
        const ClosingResult other =
            closeReference(hand.hand, object.object, start.X_WH, start.open, ofReference);
        if (began(ours) && began(other))
        {
            count(counts, number, start, ours, other, likeness);
        }
    }
    json row = counts.row();
    row["allowed_gap_m"] = full ? tolerance : 1e-4;
    return named(std::move(row), hand, object);
}

json judgePlans(const LoadedHand& hand,
                const LoadedObject& object,
                const grasp::PlannerOptions& options)
{
    std::vector<grasp::Grasp> grasps;
    const double micros = wallMicrosecondsOf(
        [&]
        {
            grasps = grasp::planGrasps(
                hand.hand, object.object, options, tools::closingEngine(options.engine));
        });
    json rejected = json::object();
    double best = 0.0;
    for (const grasp::Grasp& grasp : grasps)
    {
        best = std::max(best, grasp.quality.epsilon);
        if (grasp.reject != grasp::RejectReason::None)
        {
            json& entry = rejected[grasp::toString(grasp.reject)];
            entry = entry.is_null() ? 1 : entry.get<int>() + 1;
        }
    }
    return named({{"candidates", grasps.size()},
                  {"force_closures", tools::forceClosures(grasps)},
                  {"best_epsilon", best},
                  {"rejected", rejected},
                  {"seconds", 1e-6 * micros}},
                 hand,
                 object);
}
}  // namespace bullet_ccd::benchmarks
