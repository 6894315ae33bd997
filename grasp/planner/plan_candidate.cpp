#include "grasp/planner/plan_candidate.h"

#include "bullet_ccd/contact/contacts.h"
#include "grasp/approach/approach.h"
#include "grasp/quality/exact_epsilon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace bullet_ccd::grasp
{
namespace
{
/// Index in the environment; obstacles come after it.
constexpr std::int32_t kObject = 0;
/// How far the hand is drawn back from the first contact before it closes [m], until one closing
/// holds the object. A link that lands on the object's near side is stopped at once when closing
/// begins there; a little farther back it can come round.
constexpr std::array kRetreats{0.0, 0.005, 0.015};
/// The same for jaws on one motor, which hold between two places at most: where they do not fit at
/// one depth, they may at another.
constexpr std::array kJawRetreats{0.01, 0.02, 0.03, 0.045, 0.06};
/// Among obstacles an approach that would begin inside of one begins nearer: so far before the
/// grasp frame is at its target [m].
constexpr std::array kNearerStarts{0.15, 0.1, 0.07, 0.04, 0.02};
/// Poses of closing that differ by less are the same [m].
constexpr double kSamePose = 1e-3;
/// Sideways centring of coupled fingers: at most this many shifts.
constexpr int kMaxCentring = 2;
/// Ties in epsilon are decided by the number of contacts.
constexpr double kEpsilonTie = 1e-9;

ArticulatedToiResult translateUntilContact(const Eigen::Isometry3d& X_WH,
                                           const std::vector<double>& positions,
                                           const Eigen::Vector3d& shift,
                                           CandidateContext& context)
{
    return approachUntilContact(context.hand,
                                context.environment,
                                X_WH,
                                positions,
                                shift,
                                context.options.closing.tolerance,
                                context.work);
}

Eigen::Isometry3d shifted(Eigen::Isometry3d X_W, const Eigen::Vector3d& by)
{
    X_W.translation() += by;
    return X_W;
}

/// Sideways shift that centres the closed jaws on the object: half of the free travel across which
/// they oppose each other. Real grippers do this by compliance or by pushing the object.
Eigen::Vector3d centringShift(const Grasp& grasp, CandidateContext& context)
{
    const Preshape* preshape = findPreshape(context.hand, grasp.preshape);
    const Eigen::Isometry3d& X_HG =
        preshape == nullptr ? context.hand.X_RG : graspFrame(context.hand, *preshape);
    const Eigen::Vector3d across = (grasp.X_WH * X_HG).linear().col(0);
    const double reach = 2.0 * context.object.radius;
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    for (const double sign : {1.0, -1.0})
    {
        const ArticulatedToiResult result =
            translateUntilContact(grasp.X_WH, grasp.positions, sign * reach * across, context);
        if (result.status == ToiStatus::Hit && result.time * reach / 2.0 > best.norm())
        {
            best = sign * result.time * reach / 2.0 * across;
        }
    }
    return best;
}

bool better(const Grasp& a, const Grasp& b)
{
    if (std::abs(a.quality.epsilon - b.quality.epsilon) > kEpsilonTie)
    {
        return a.quality.epsilon > b.quality.epsilon;
    }
    return a.contacts.size() > b.contacts.size();
}

/// Travels along the approach at which closing is tried, the first contact first, but not where
/// that is with an obstacle. The grasp frame is at its target after `centerDistance`.
std::vector<double> closingTravels(double centerDistance,
                                   double travel,
                                   bool meetsObstacle,
                                   bool areCoupled)
{
    std::vector<double> travels;
    const auto add = [&](double value)
    {
        const bool known =
            std::any_of(travels.begin(),
                        travels.end(),
                        [&](double other) { return std::abs(other - value) < kSamePose; });
        if (value >= 0.0 && !known)
        {
            travels.push_back(value);
        }
    };
    for (const double retreat : kRetreats)
    {
        add(travel - retreat);
    }
    if (centerDistance < travel)
    {
        add(centerDistance);
    }
    if (areCoupled)
    {
        for (const double retreat : kJawRetreats)
        {
            add(travel - retreat);
        }
    }
    if (meetsObstacle)
    {
        travels.erase(travels.begin());
    }
    return travels;
}

}  // namespace

Grasp closeCentred(const Grasp& approached,
                   const Eigen::Isometry3d& X_WH,
                   const std::vector<double>& preshape,
                   CandidateContext& context)
{
    Grasp grasp = approached;
    closeAndScore(grasp, X_WH, preshape, context);
    if (!fingersAreCoupled(context.hand))
    {
        return grasp;
    }
    for (int round = 0; round < kMaxCentring && !grasp.positions.empty(); ++round)
    {
        const Eigen::Vector3d shift = centringShift(grasp, context);
        // The open hand must be able to move there.
        const ArticulatedToiResult way =
            translateUntilContact(grasp.X_WH, preshape, shift, context);
        if (shift.norm() <= context.options.closing.tolerance || way.status != ToiStatus::Separated)
        {
            break;
        }
        Grasp centred = approached;
        closeAndScore(centred, shifted(grasp.X_WH, shift), preshape, context);
        if (!better(centred, grasp))
        {
            break;
        }
        grasp = std::move(centred);
    }
    return grasp;
}

std::vector<GraspContact> collectContacts(const HandModel& hand,
                                          const GraspObject& object,
                                          const Eigen::Isometry3d& X_WH,
                                          std::span<const double> positions,
                                          const PlannerOptions& options)
{
    const std::vector<Eigen::Isometry3d> X_WL = linkPoses(hand.robot.tree, X_WH, positions);
    std::vector<GraspContact> contacts;
    for (std::size_t link = 0; link < hand.linkTrees.size(); ++link)
    {
        if (hand.linkTrees[link] == nullptr)
        {
            continue;
        }
        std::vector<Contact> found = findContacts(*hand.linkTrees[link],
                                                  X_WL[link],
                                                  object.tree,
                                                  Eigen::Isometry3d::Identity(),
                                                  options.closing.contactThreshold);
        std::stable_sort(found.begin(),
                         found.end(),
                         [](const Contact& a, const Contact& b) { return a.gap < b.gap; });
        const std::size_t first = contacts.size();
        for (const Contact& contact : found)
        {
            const bool repeated = std::any_of(
                contacts.begin() + static_cast<std::ptrdiff_t>(first),
                contacts.end(),
                [&](const GraspContact& kept)
                { return (kept.point - contact.pointB).norm() < options.minContactSpacing; });
            if (!repeated)
            {
                contacts.push_back({.link = static_cast<std::int32_t>(link),
                                    .point = contact.pointB,
                                    .normal = contact.normal,
                                    .gap = contact.gap});
            }
        }
    }
    return contacts;
}

std::vector<Wrench> wrenchesOf(const Grasp& grasp,
                               const GraspObject& object,
                               const PlannerOptions& options)
{
    return contactWrenches(grasp.contacts,
                           object.centerOfMass,
                           {.friction = options.friction,
                            .coneEdges = pyramidEdges(options),
                            .torqueScale = object.radius,
                            .forceClosureThreshold = options.forceClosureThreshold});
}

double epsilonOf(const Grasp& grasp, const GraspObject& object, const PlannerOptions& options)
{
    return options.coneEdges > 0 ? wrenchSpaceEpsilon(wrenchesOf(grasp, object, options))
                                 : exactEpsilon(grasp.contacts,
                                                object.centerOfMass,
                                                {.law = {.friction = options.friction},
                                                 .torqueScale = object.radius,
                                                 .resolution = kEpsilonResolution,
                                                 .share = kEpsilonShare})
                                       .lower;
}

void addVolume(Grasp& grasp, const GraspObject& object, const PlannerOptions& options)
{
    if (grasp.quality.forceClosure)
    {
        grasp.quality.volume =
            wrenchSpaceQuality(wrenchesOf(grasp, object, options), options.forceClosureThreshold)
                .volume;
    }
}

RejectReason rejectReasonOf(ToiStatus status, RejectReason overlap)
{
    switch (status)
    {
        case ToiStatus::Overlapping:
            return overlap;
        case ToiStatus::IterationLimit:
        case ToiStatus::Stopped:
            return RejectReason::IterationLimit;
        case ToiStatus::Separated:
        case ToiStatus::Hit:
        case ToiStatus::TouchingLeaving:
        case ToiStatus::TouchingPressing:
            break;
    }
    return RejectReason::None;
}

void closeAndScore(Grasp& grasp,
                   const Eigen::Isometry3d& X_WH,
                   const std::vector<double>& preshape,
                   CandidateContext& context)
{
    const PlannerOptions& options = context.options;
    const ClosingResult closing =
        context.close(context.hand, context.object, X_WH, preshape, options.closing);
    grasp.X_WH = X_WH;
    grasp.positions = closing.positions;
    grasp.stops = closing.stops;
    // The approach certified that the hand is clear of the object here, so what overlaps is the
    // hand.
    grasp.reject = rejectReasonOf(closing.status, RejectReason::SelfOverlap);
    if (grasp.reject == RejectReason::None && closing.touchedObstacle)
    {
        grasp.reject = RejectReason::Obstacle;
    }
    if (grasp.reject != RejectReason::None)
    {
        grasp.positions.clear();
        return;
    }
    grasp.contacts = collectContacts(context.hand, context.object, X_WH, grasp.positions, options);
    if (grasp.contacts.size() < 2)
    {
        grasp.reject = RejectReason::TooFewContacts;
        return;
    }
    grasp.quality.epsilon = epsilonOf(grasp, context.object, options);
    grasp.quality.forceClosure =
        grasp.quality.epsilon > 0.0 && grasp.quality.epsilon >= options.forceClosureThreshold;
    grasp.reject = grasp.quality.forceClosure ? RejectReason::None : RejectReason::NoForceClosure;
}

void rejectPenetration(Grasp& grasp, const CandidateContext& context)
{
    if (grasp.positions.empty())
    {
        return;
    }
    // The contacts are all that is near, and of each link the nearest is among them.
    const bool touches = std::any_of(grasp.contacts.begin(),
                                     grasp.contacts.end(),
                                     [](const GraspContact& contact)
                                     { return !(contact.gap > PenetrationCheck::kResolution); });
    const bool penetrates = touches ? !context.check.at(grasp.X_WH, grasp.positions).clean()
                                    : context.check.holdsInside(grasp.X_WH, grasp.positions);
    if (penetrates)
    {
        grasp.reject = RejectReason::Penetration;
    }
}

std::vector<RigidBody> bodiesNear(const ApproachCandidate& candidate,
                                  const GraspObject& object,
                                  const Surroundings& surroundings)
{
    std::vector<RigidBody> bodies{{.tree = &object.tree, .motion = {}}};
    if (!surroundings.obstacles.empty())
    {
        for (const std::int32_t index : reachable(surroundings.boxes[candidate.preshape],
                                                  candidate.X_WStart,
                                                  candidate.distance * candidate.direction_W,
                                                  surroundings.obstacles))
        {
            bodies.push_back(surroundings.obstacles[static_cast<std::size_t>(index)]);
        }
    }
    return bodies;
}

Grasp planCandidate(const ApproachCandidate& candidate, CandidateContext& context)
{
    const Preshape& preshape = context.hand.preshapes[candidate.preshape];
    Grasp approached;
    approached.candidate = candidate.number;
    approached.preshape = preshape.name;
    approached.source = toString(candidate.source);
    approached.approach_W = candidate.direction_W;
    double begin = 0.0;
    const auto approachFrom = [&](double travel)
    {
        begin = travel;
        approached.X_WStart = shifted(candidate.X_WStart, travel * candidate.direction_W);
        return translateUntilContact(approached.X_WStart,
                                     preshape.positions,
                                     (candidate.distance - travel) * candidate.direction_W,
                                     context);
    };
    ArticulatedToiResult approach = approachFrom(0.0);
    for (const double before : kNearerStarts)
    {
        const double travel = std::min(candidate.centerDistance, candidate.distance) - before;
        if (approach.status == ToiStatus::Overlapping && context.environment.bodies().size() > 1 &&
            travel > 0.0)
        {
            approach = approachFrom(travel);
        }
    }
    approached.reject = approach.status == ToiStatus::Separated
                            ? RejectReason::NoApproachHit
                            : rejectReasonOf(approach.status, RejectReason::OverlapAtStart);
    if (approached.reject != RejectReason::None)
    {
        return approached;
    }
    approached.approachDistance = approach.time * (candidate.distance - begin);
    // Fingers that reach around the object to what it stands on are drawn back from there.
    const bool meetsObstacle =
        !approach.contacts.empty() && approach.contacts.front().obstacle != kObject;

    std::optional<Grasp> best;
    for (const double travel : closingTravels(candidate.centerDistance - begin,
                                              approached.approachDistance,
                                              meetsObstacle,
                                              fingersAreCoupled(context.hand)))
    {
        const Eigen::Isometry3d X_WH = shifted(approached.X_WStart, travel * candidate.direction_W);
        Grasp grasp = closeCentred(approached, X_WH, preshape.positions, context);
        if (!best || better(grasp, *best))
        {
            best = std::move(grasp);
        }
        if (best->reject == RejectReason::None)
        {
            break;
        }
    }
    if (!best || (meetsObstacle && best->reject != RejectReason::None))
    {
        approached.reject = RejectReason::Obstacle;
        return approached;
    }
    rejectPenetration(*best, context);
    return *std::move(best);
}
}  // namespace bullet_ccd::grasp
