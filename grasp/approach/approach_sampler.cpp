#include "grasp/approach/approach_sampler.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "grasp/approach/approach_aim.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStartMargin = 0.01;  // [m] clear space between the bounding spheres
constexpr double kOffsetAll = 0.003;   // [m] seeded offset of the target in every direction
constexpr double kElongated = 1.5;     // longest over middle extent from which an object is long
constexpr double kLongOffset = 0.3;    // of the longest extent of a long object
constexpr double kShortOffset = 0.1;   // of the longest extent of other objects
constexpr double kOpeningUsed = 0.9;   // part of the hand's opening that an object may fill
// Part of a preshape's opening that an object may fill for the preshape to be used for it. Less
// than above: openings are measured between the middles of the tips, and here the whole object
// counts.
constexpr double kPreshapeUsed = 0.7;
constexpr double kRayGrid = 0.006;  // [m] spacing of the rays that measure the local width
constexpr double kThinShare =
    0.7;                       // of the tries oppose along the thinnest axis, others the middle
constexpr double kFlat = 0.8;  // thinnest over longest extent below which the axes mean much
constexpr double kKeepDirection = 0.15;  // cost of turning the direction of approach by a radian
constexpr int kTries = 8;
constexpr int kFacingRounds = 3;
constexpr double kSmallestOpening = 0.03;  // [m] for hands whose tips say nothing

/// Outermost link with geometry of a finger.
std::optional<std::size_t> tipOf(const HandModel& hand, const Finger& finger)
{
    for (auto link = finger.links.rbegin(); link != finger.links.rend(); ++link)
    {
        if (const auto index = static_cast<std::size_t>(*link); hand.linkTrees[index] != nullptr)
        {
            return index;
        }
    }
    return std::nullopt;
}

/// What lies free between the fingertips along x of the grasp frame, however far the frame is from
/// the tips: nothing if all are on one side of it.
std::optional<double> freeDistance(const HandModel& hand,
                                   const std::vector<Eigen::Isometry3d>& X_GL)
{
    double below = -std::numeric_limits<double>::infinity();
    double above = std::numeric_limits<double>::infinity();
    for (const Finger& finger : hand.fingers)
    {
        const std::optional<std::size_t> tip = tipOf(hand, finger);
        if (!tip)
        {
            continue;
        }
        double lower = std::numeric_limits<double>::infinity();
        double upper = -lower;
        for (const Eigen::Vector3d& vertex : hand.linkTrees[*tip]->mesh().vertices)
        {
            const double x = (X_GL[*tip] * vertex).x();
            lower = std::min(lower, x);
            upper = std::max(upper, x);
        }
        below = lower + upper < 0.0 ? std::max(below, upper) : below;
        above = lower + upper < 0.0 ? above : std::min(above, lower);
    }
    return std::isfinite(above - below) ? std::optional(std::max(0.0, above - below))
                                        : std::nullopt;
}

/// Point `number` of `count` on a cap about z of the unit sphere that has this share of its area:
/// rings of equal area, each turned by the golden angle.
Eigen::Vector3d fibonacciDirection(std::int64_t number, std::int64_t count, double share)
{
    const double goldenAngle = std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double z =
        1.0 - share * (2.0 * static_cast<double>(number) + 1.0) / static_cast<double>(count);
    const double ring = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double angle = goldenAngle * static_cast<double>(number);
    return {ring * std::cos(angle), ring * std::sin(angle), z};
}

/// Point `turn` of an endless sequence on such a cap: the additive recurrence of the plastic
/// number.
Eigen::Vector3d spreadDirection(std::int64_t turn, double share)
{
    constexpr double kPlastic = 1.3247179572447460;
    const auto part = [&](double step)
    {
        const double x = 0.5 + static_cast<double>(turn) * step;
        return x - std::floor(x);
    };
    const double z = 1.0 - 2.0 * share * part(1.0 / kPlastic);
    const double ring = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double angle = 2.0 * std::numbers::pi * part(1.0 / (kPlastic * kPlastic));
    return {ring * std::cos(angle), ring * std::sin(angle), z};
}

/// Uniformly distributed rotation, by Shoemake's subgroup algorithm.
Eigen::Quaterniond randomRotation(Draws& draws)
{
    const double u = draws.unit();
    const double a = 2.0 * std::numbers::pi * draws.unit();
    const double b = 2.0 * std::numbers::pi * draws.unit();
    const double p = std::sqrt(1.0 - u);
    const double q = std::sqrt(u);
    return {q * std::cos(b), p * std::sin(a), p * std::cos(a), q * std::sin(b)};
}

/// Rotation that takes z to straight down, and turns by `angle` about it.
Eigen::Quaterniond aboutDown(const Eigen::Vector3d& up, double angle)
{
    return rotationBetween(Eigen::Vector3d::UnitZ(), -up) *
           Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
}

/// `direction` turned by up to `angle` about a random axis across it.
Eigen::Vector3d jittered(const Eigen::Vector3d& direction, double angle, Draws& draws)
{
    const Eigen::Vector3d u = direction.unitOrthogonal();
    const Eigen::Vector3d v = direction.cross(u);
    const double around = 2.0 * std::numbers::pi * draws.unit();
    const double by = angle * std::sqrt(draws.unit());
    return std::cos(by) * direction + std::sin(by) * (std::cos(around) * u + std::sin(around) * v);
}

/// Along a thin principal axis, either way.
Eigen::Vector3d drawOpposition(const ObjectShape& shape, Draws& draws)
{
    const int axis = draws.unit() < kThinShare ? 2 : 1;
    return draws.coin() ? Eigen::Vector3d(shape.axes.col(axis))
                        : Eigen::Vector3d(-shape.axes.col(axis));
}

/// Orientation of the grasp frame for one try: the first keeps the direction of the sequence, odd
/// ones turn it square to a thin principal axis of a flat object and oppose the fingers along that
/// axis, the others vary it within its neighbourhood.
Eigen::Matrix3d proposeOrientation(int attempt,
                                   const Eigen::Vector3d& direction,
                                   double cell,
                                   const ObjectShape& shape,
                                   Draws& draws)
{
    const Eigen::Vector3d thin = shape.axes.col(2);
    const Eigen::Vector3d middle = shape.axes.col(1);
    const Eigen::Vector3d& opposition = draws.unit() < kThinShare ? thin : middle;
    const bool isFlat = shape.extents()[2] < kFlat * shape.extents()[0];
    Eigen::Vector3d z = direction;
    if (attempt % 2 == 1 && isFlat)
    {
        z = direction - direction.dot(opposition) * opposition;
        z = z.norm() > 0.1 ? z.normalized() : opposition.unitOrthogonal();
    }
    else if (attempt > 0)
    {
        z = jittered(direction, cell * static_cast<double>(attempt) / kTries, draws);
    }
    const double sign = draws.coin() ? 1.0 : -1.0;
    return frameFrom(z, sign * opposition);
}

/// Turns the frame so that its x axis runs along the direction in which the object's surfaces
/// oppose each other there, and moves its origin to the middle between them: flat jaws then lie
/// flat.
void faceTheSurfaces(Eigen::Isometry3d& X_WG, const GraspObject& object)
{
    for (int round = 0; round < kFacingRounds; ++round)
    {
        const LocalWidth local = localWidth(object, X_WG, kRayGrid);
        if (local.hits == 0)
        {
            return;
        }
        const Eigen::Vector3d across = X_WG.linear() * local.opposition;
        const Eigen::Vector3d z = X_WG.linear().col(2);
        X_WG.translation() += 0.5 * (local.lower + local.upper) * X_WG.linear().col(0);
        X_WG.linear() = frameFrom((z - z.dot(across) * across).normalized(), across);
    }
}

/// Smaller is better. An object that does not fit costs what it is too wide; then faces that the
/// fingers meet squarely are preferred, and narrow places a little.
double cost(const LocalWidth& local, const OpenHand& open)
{
    if (local.hits == 0)
    {
        return 10.0;
    }
    const double room = kOpeningUsed * open.opening;
    const double excess = std::max(0.0, local.width() - room) / open.opening;
    const double missed = static_cast<double>(LocalWidth::kRays - local.hits) / LocalWidth::kRays;
    // A few degrees decide whether a flat jaw rests on a face or on one corner.
    const double askew = std::acos(std::clamp(local.opposition.x(), -1.0, 1.0));
    return 4.0 * excess + (1.0 - local.squareness) + 3.0 * std::min(askew, 0.35) + 0.5 * missed +
           0.2 * local.width() / open.opening;
}

/// Point that the grasp frame is aimed at.
Eigen::Vector3d targetPoint(const GraspObject& object, const ObjectShape& shape, Draws& draws)
{
    const Eigen::Vector3d extents = shape.extents();
    const double along = extents[0] > kElongated * extents[1] ? kLongOffset : kShortOffset;
    Eigen::Vector3d target =
        object.centerOfMass + along * extents[0] * draws.between(-1.0, 1.0) * shape.axes.col(0);
    for (int k = 0; k < 3; ++k)
    {
        target[k] += kOffsetAll * draws.between(-1.0, 1.0);
    }
    return target;
}

/// The candidate in its sequence.
struct Place
{
    std::uint64_t seed = 0;
    std::int64_t number = 0;
    std::int64_t count = 1;
    std::int64_t turn = 0;  ///< number among the candidates with its preshape
    /// Of a mixed sequence: number among all directions; else they follow from `number`.
    std::optional<std::int64_t> spread{};

    [[nodiscard]] Draws draws() const { return {seed, static_cast<std::uint64_t>(number)}; }
    /// Of the whole sequence.
    [[nodiscard]] Draws sequence() const { return {seed, ~std::uint64_t{0}}; }
};

/// Of kTries proposals the cheapest; turning away from `direction` costs, too.
template <typename Propose>
Eigen::Isometry3d cheapest(const Propose& propose,
                           const Eigen::Vector3d& direction,
                           const GraspObject& object,
                           const OpenHand& open)
{
    Eigen::Isometry3d best = Eigen::Isometry3d::Identity();
    double bestCost = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < kTries; ++attempt)
    {
        const Eigen::Isometry3d X_WG = propose(attempt);
        const double turned = std::acos(std::clamp(X_WG.linear().col(2).dot(direction), -1.0, 1.0));
        const double itsCost =
            cost(localWidth(object, X_WG, kRayGrid), open) + kKeepDirection * turned;
        if (itsCost < bestCost)
        {
            best = X_WG;
            bestCost = itsCost;
        }
    }
    return best;
}

/// Its share of the directions of the sphere, or of the cap above the table.
Eigen::Isometry3d aroundTheObject(const Place& place,
                                  const GraspObject& object,
                                  const ObjectShape& shape,
                                  const OpenHand& open,
                                  const ApproachOptions& options)
{
    const double share = options.tableTop ? 0.5 * (1.0 - std::cos(options.maxTilt)) : 1.0;
    const Eigen::Vector3d ofCap =
        place.spread ? spreadDirection(*place.spread, share)
                     : fibonacciDirection(place.number % place.count, place.count, share);
    // The rotation belongs to the sequence, everything else to the candidate.
    Draws sequence = place.sequence();
    const Eigen::Vector3d direction =
        options.tableTop ? aboutDown(options.up, 2.0 * std::numbers::pi * sequence.unit()) * ofCap
                         : randomRotation(sequence) * ofCap;
    // Radius of its share [rad].
    const double cell = 2.0 * std::sqrt(share) / std::sqrt(static_cast<double>(place.count));
    Draws draws = place.draws();
    const auto propose = [&](int attempt)
    {
        Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
        X_WG.linear() = proposeOrientation(attempt, direction, cell, shape, draws);
        X_WG.translation() = targetPoint(object, shape, draws);
        if (attempt % 2 == 1)
        {
            faceTheSurfaces(X_WG, object);
        }
        X_WG.linear() = withinLimits(X_WG.linear(), options, draws);
        return X_WG;
    };
    return cheapest(propose, direction, object, open);
}

/// Against the normal of a point of the surface, turned a little; odd tries oppose the fingers as
/// the surfaces do there.
Eigen::Isometry3d atTheSurface(const Place& place,
                               const GraspObject& object,
                               const ObjectShape& shape,
                               const OpenHand& open,
                               const ApproachOptions& options)
{
    Draws draws = place.draws();
    const ApproachAim aim = surfaceAim(object, options, draws);
    const auto propose = [&](int attempt)
    {
        const Eigen::Vector3d z = withinTilt(jittered(aim.direction, kLargestTurn, draws), options);
        Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
        X_WG.linear() = frameFrom(z, drawOpposition(shape, draws));
        X_WG.translation() = middleOnLine(object, aim.point, z);
        if (const LocalWidth local = localWidth(object, X_WG, kRayGrid);
            attempt % 2 == 1 && local.hits > 0)
        {
            X_WG.linear() = frameFrom(z, X_WG.linear() * local.opposition);
        }
        X_WG.linear() = withinLimits(X_WG.linear(), options, draws);
        return X_WG;
    };
    return cheapest(propose, aim.direction, object, open);
}

/// Squarely at a face of the object's box.
Eigen::Isometry3d atTheBox(const Place& place,
                           const GraspObject& object,
                           const ObjectShape& shape,
                           const ApproachOptions& options)
{
    Draws sequence = place.sequence();
    Draws draws = place.draws();
    const ApproachAim aim = boxAim(object, shape, options, place.turn, sequence);
    const double sign = draws.coin() ? 1.0 : -1.0;
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.linear() = withinLimits(frameFrom(aim.direction, sign * aim.opposition), options, draws);
    X_WG.translation() = middleOnLine(object, aim.point, X_WG.linear().col(2));
    return X_WG;
}

/// Across what is thin somewhere.
Eigen::Isometry3d atThePinch(const Place& place,
                             const GraspObject& object,
                             const OpenHand& open,
                             const ApproachOptions& options)
{
    Draws draws = place.draws();
    const ApproachAim aim = pinchAim(object, kOpeningUsed * open.opening, options, draws);
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.linear() = withinLimits(frameFrom(aim.direction, aim.opposition), options, draws);
    X_WG.translation() = aim.point;
    return X_WG;
}

/// The grasp frame where the approach would bring it.
Eigen::Isometry3d targetFrame(const Place& place,
                              const GraspObject& object,
                              const ObjectShape& shape,
                              const OpenHand& open,
                              ApproachSource source,
                              const ApproachOptions& options)
{
    switch (source)
    {
        case ApproachSource::Surface:
            return atTheSurface(place, object, shape, open, options);
        case ApproachSource::Boxes:
            return atTheBox(place, object, shape, options);
        case ApproachSource::Pinch:
            return atThePinch(place, object, open, options);
        case ApproachSource::Sphere:
        case ApproachSource::Mixed:
            break;
    }
    return aroundTheObject(place, object, shape, open, options);
}
ApproachCandidate candidateAt(const Place& place,
                              const HandModel& hand,
                              const GraspObject& object,
                              const ApproachShapes& shapes,
                              ApproachSource source,
                              std::size_t preshape,
                              const ApproachOptions& options)
{
    const OpenHand& open = shapes.hands[preshape];
    Eigen::Isometry3d X_WG = targetFrame(place, object, shapes.object, open, source, options);

    ApproachCandidate candidate{.number = place.number, .source = source, .preshape = preshape};
    candidate.direction_W = X_WG.linear().col(2);
    // The ball of the hand about its grasp frame, moved back until it is clear of the object's.
    const double aside = (X_WG.translation() - object.centerOfMass).norm();
    const double back = open.radius + object.radius + aside + kStartMargin + options.standoff;
    candidate.centerDistance = back;
    candidate.distance = back + object.radius + aside + open.radius;
    if (options.reach > 0.0)
    {
        candidate.distance = std::min(candidate.distance, options.reach);
    }
    X_WG.translation() -= back * candidate.direction_W;
    candidate.X_WStart = X_WG * graspFrame(hand, hand.preshapes[preshape]).inverse();
    return candidate;
}
}  // namespace

OpenHand openHand(const HandModel& hand, const Preshape& preshape)
{
    const std::vector<Eigen::Isometry3d> X_GL =
        linkPoses(hand.robot.tree, graspFrame(hand, preshape).inverse(), preshape.positions);
    OpenHand open;
    for (std::size_t link = 0; link < hand.linkTrees.size(); ++link)
    {
        if (hand.linkTrees[link] != nullptr)
        {
            for (const Eigen::Vector3d& vertex : hand.linkTrees[link]->mesh().vertices)
            {
                open.radius = std::max(open.radius, (X_GL[link] * vertex).norm());
            }
        }
    }
    double lower = std::numeric_limits<double>::infinity();
    double upper = -lower;
    for (const Finger& finger : hand.fingers)
    {
        if (const auto tip = tipOf(hand, finger))
        {
            const double x = (X_GL[*tip] * bounds(hand.linkTrees[*tip]->mesh()).center()).x();
            lower = std::min(lower, x);
            upper = std::max(upper, x);
        }
    }
    open.opening = std::max(kSmallestOpening, upper - lower);
    if (fingersAreCoupled(hand))
    {
        open.opening = freeDistance(hand, X_GL).value_or(open.opening);
    }
    return open;
}

std::vector<std::size_t> fittingPreshapes(const ApproachShapes& shapes)
{
    std::vector<std::size_t> fitting;
    for (std::size_t k = 0; k < shapes.hands.size(); ++k)
    {
        if (shapes.object.extents()[2] <= kPreshapeUsed * shapes.hands[k].opening)
        {
            fitting.push_back(k);
        }
    }
    if (fitting.empty())
    {
        fitting.resize(shapes.hands.size());
        std::iota(fitting.begin(), fitting.end(), std::size_t{0});
    }
    if (shapes.widestOnly && !fitting.empty())
    {
        fitting = {*std::ranges::max_element(
            fitting, {}, [&](std::size_t k) { return shapes.hands[k].opening; })};
    }
    return fitting;
}

ApproachCandidate sampleApproach(const HandModel& hand,
                                 const GraspObject& object,
                                 std::uint64_t seed,
                                 std::int64_t number,
                                 std::int64_t count,
                                 const ApproachOptions& options)
{
    return sampleApproach(hand, object, approachShapes(hand, object), seed, number, count, options);
}

ApproachShapes approachShapes(const HandModel& hand, const GraspObject& object)
{
    ApproachShapes shapes{.object = objectShape(object), .hands = {}};
    for (const Preshape& preshape : hand.preshapes)
    {
        shapes.hands.push_back(openHand(hand, preshape));
    }
    return shapes;
}

ApproachCandidate sampleApproach(const HandModel& hand,
                                 const GraspObject& object,
                                 const ApproachShapes& shapes,
                                 std::uint64_t seed,
                                 std::int64_t number,
                                 std::int64_t count,
                                 const ApproachOptions& options)
{
    std::vector<std::size_t> fitting = fittingPreshapes(shapes);
    if (options.source == ApproachSource::Pinch)  // what is pinched is thinner than the object
    {
        fitting.resize(shapes.hands.size());
        std::iota(fitting.begin(), fitting.end(), std::size_t{0});
    }
    require(count > 0 && number >= 0, "sampleApproach: number >= 0 and count > 0 are needed");
    require(!fitting.empty(), "sampleApproach: the hand has no preshape");
    checkApproachOptions(options);
    const auto preshapes = static_cast<std::int64_t>(fitting.size());
    if (options.source == ApproachSource::Mixed)
    {
        constexpr auto kSources = static_cast<std::int64_t>(kMixedSources.size());
        const ApproachTurn turn{
            .source = kMixedSources[static_cast<std::size_t>(number % kSources)],
            .preshape = fitting[static_cast<std::size_t>(number / kSources % preshapes)],
            .turn = number / (kSources * preshapes)};
        return sampleApproach(hand, object, shapes, seed, number, count, turn, options);
    }
    const Place place{.seed = seed, .number = number, .count = count, .turn = number / preshapes};
    return candidateAt(place,
                       hand,
                       object,
                       shapes,
                       options.source,
                       fitting[static_cast<std::size_t>(number % preshapes)],
                       options);
}

ApproachCandidate sampleApproach(const HandModel& hand,
                                 const GraspObject& object,
                                 const ApproachShapes& shapes,
                                 std::uint64_t seed,
                                 std::int64_t number,
                                 std::int64_t count,
                                 const ApproachTurn& turn,
                                 const ApproachOptions& options)
{
    require(count > 0 && number >= 0 && turn.turn >= 0,
            "sampleApproach: number >= 0, turn >= 0 and count > 0 are needed");
    require(turn.preshape < hand.preshapes.size() && turn.source != ApproachSource::Mixed,
            "sampleApproach: the turn must name a preshape of the hand and one source");
    checkApproachOptions(options);
    const auto preshapes = static_cast<std::int64_t>(hand.preshapes.size());
    const Place place{.seed = seed,
                      .number = number,
                      .count = count,
                      .turn = turn.turn,
                      .spread = turn.turn * preshapes + static_cast<std::int64_t>(turn.preshape)};
    return candidateAt(place, hand, object, shapes, turn.source, turn.preshape, options);
}
}  // namespace bullet_ccd::grasp
