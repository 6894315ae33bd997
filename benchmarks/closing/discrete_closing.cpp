#include "benchmarks/closing/discrete_closing.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "grasp/closing/closing_drives.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::ClosingDrives;
using grasp::ClosingResult;
using grasp::GraspObject;
using grasp::HandModel;

/// Surfaces closer than this cannot be told from intersecting ones [m].
constexpr double kOverlap = 1e-12;

/// A link and another, or the object (kNone).
struct Pair
{
    std::int32_t link;
    std::int32_t other;
};

/// Puts the hand where it is at a part of the step in hand, in [0, 1].
using PlaceAt = std::function<void(double)>;

void findOverlaps(LinkProximity& proximity, std::span<const Pair> pairs, std::vector<Pair>& found)
{
    found.clear();
    std::copy_if(pairs.begin(),
                 pairs.end(),
                 std::back_inserter(found),
                 [&](const Pair& pair) { return proximity.overlap(pair.link, pair.other); });
}

double smallestDistance(LinkProximity& proximity, std::span<const Pair> pairs)
{
    double smallest = std::numeric_limits<double>::infinity();
    for (const Pair& pair : pairs)
    {
        smallest = std::min(smallest, proximity.distance(pair.link, pair.other, smallest));
    }
    return smallest;
}

/// The part of the step, below `end`, at which the pairs are apart by less than the contact gap;
/// where none is found, the last at which they were apart.
double bisect(LinkProximity& proximity,
              std::span<const Pair> pairs,
              const PlaceAt& placeAt,
              double end,
              const DiscreteOptions& options)
{
    double begin = 0.0;
    double middle = 0.0;  // the contact is often where the last one was
    for (int i = 0; i < options.maxHalvings; ++i)
    {
        placeAt(middle);
        const double distance = smallestDistance(proximity, pairs);
        if (distance > 0.0 && distance < options.contactGap)
        {
            return middle;
        }
        (distance > 0.0 ? begin : end) = middle;
        middle = 0.5 * (begin + end);
    }
    placeAt(begin);
    return begin;
}

/// Takes one step: the part of it that was done, and the pairs that ended it.
double takeStep(LinkProximity& proximity,
                std::span<const Pair> pairs,
                const PlaceAt& placeAt,
                const DiscreteOptions& options,
                std::vector<Pair>& met)
{
    double part = 1.0;
    met.clear();
    std::vector<Pair> overlaps;
    placeAt(part);
    findOverlaps(proximity, pairs, overlaps);
    while (!overlaps.empty())
    {
        met = overlaps;
        const double before = part;
        part = bisect(proximity, met, placeAt, part, options);
        if (part == 0.0 || part == before)
        {
            return part;
        }
        findOverlaps(proximity, pairs, overlaps);
    }
    return part;
}

/// All pairs of which a link moves.
std::vector<Pair> movingPairs(const HandModel& hand, std::span<const char> moves)
{
    const auto isMoving = [&](std::int32_t link)
    { return moves[static_cast<std::size_t>(link)] != 0; };
    std::vector<Pair> pairs;
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(moves.size()); ++link)
    {
        if (isMoving(link) && hand.linkTrees[static_cast<std::size_t>(link)] != nullptr)
        {
            pairs.push_back({link, kNone});
        }
    }
    for (const auto& [a, b] : hand.selfPairs)
    {
        if (isMoving(a) || isMoving(b))
        {
            pairs.push_back({a, b});
        }
    }
    return pairs;
}

/// True for every link that a running joint moves.
std::vector<char> movingLinks(const HandModel& hand, const std::vector<double>& speeds)
{
    std::vector<char> moves(speeds.size(), 0);
    for (std::size_t i = 1; i < speeds.size(); ++i)
    {
        const auto parent = static_cast<std::size_t>(hand.robot.tree.links[i].parent);
        moves[i] = speeds[i] != 0.0 || moves[parent] != 0 ? 1 : 0;
    }
    return moves;
}
}  // namespace

std::unique_ptr<LinkProximity> treeProximity(const HandModel& hand, const GraspObject& object)
{
    using Pose = Eigen::Isometry3d;
    const auto treeOf = [&](std::int32_t body) -> const SsvTree&
    { return body == kNone ? object.tree : *hand.linkTrees[static_cast<std::size_t>(body)]; };
    const auto distance =
        [=](std::int32_t a, const Pose& X_WA, std::int32_t b, const Pose& X_WB, double bound)
    { return treeDistance(treeOf(a), treeOf(b), X_WB.inverse() * X_WA, bound).distance; };
    const auto overlap = [=](std::int32_t a, const Pose& X_WA, std::int32_t b, const Pose& X_WB)
    { return distance(a, X_WA, b, X_WB, kOverlap) < kOverlap; };
    return std::make_unique<LinkProximity>(overlap, distance);
}

double discreteApproach(LinkProximity& proximity,
                        const HandModel& hand,
                        const Eigen::Isometry3d& X_WStart,
                        const Eigen::Vector3d& shift,
                        const std::vector<double>& positions,
                        const DiscreteOptions& options)
{
    require(options.approachStep > 0.0, "discreteApproach: the step must be positive");
    std::vector<Pair> pairs;
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(positions.size()); ++link)
    {
        if (hand.linkTrees[static_cast<std::size_t>(link)] != nullptr)
        {
            pairs.push_back({link, kNone});
        }
    }
    const std::vector<Eigen::Isometry3d> X_WL = linkPoses(hand.robot.tree, X_WStart, positions);
    std::vector<Eigen::Isometry3d> moved = X_WL;
    const auto steps = static_cast<std::int64_t>(std::ceil(shift.norm() / options.approachStep));
    std::vector<Pair> met;
    for (std::int64_t step = 0; step < steps; ++step)
    {
        const double begin = static_cast<double>(step) / static_cast<double>(steps);
        const auto travelAt = [&](double part)
        { return begin + part / static_cast<double>(steps); };
        const double part = takeStep(
            proximity,
            pairs,
            [&](double at)
            {
                for (std::size_t i = 0; i < X_WL.size(); ++i)
                {
                    moved[i].translation() = X_WL[i].translation() + travelAt(at) * shift;
                }
                proximity.place(moved);
            },
            options,
            met);
        if (!met.empty())
        {
            return travelAt(part);
        }
    }
    return std::numeric_limits<double>::infinity();
}

ClosingResult discreteClosing(LinkProximity& proximity,
                              const HandModel& hand,
                              const Eigen::Isometry3d& X_WH,
                              const std::vector<double>& positions,
                              const DiscreteOptions& options)
{
    require(options.closingStep > 0.0, "discreteClosing: the step must be positive");
    ClosingDrives drives(hand, positions);
    ClosingResult result;
    std::vector<Pair> met;
    std::vector<double> posture;
    double time = 0.0;
    std::vector<Pair> pairs = movingPairs(hand, movingLinks(hand, drives.speeds()));
    while (drives.isRunning() && result.steps < options.maxSteps)
    {
        const double step = options.closingStep / drives.pace();
        const auto timeAt = [&](double part) { return time + part * step; };
        const double part = takeStep(
            proximity,
            pairs,
            [&](double at)
            {
                drives.positionsAt(timeAt(at), posture);
                proximity.place(linkPoses(hand.robot.tree, X_WH, posture));
            },
            options,
            met);
        ++result.steps;
        time = timeAt(part);
        drives.advanceTo(time);
        for (const Pair& pair : met)
        {
            if (proximity.distance(pair.link, pair.other, options.contactLayer) <
                options.contactLayer)
            {
                result.status = ToiStatus::Hit;
                drives.stopLink(pair.link, time, pair.other == kNone);
                if (pair.other != kNone)
                {
                    drives.stopLink(pair.other, time, false);
                }
            }
        }
        pairs = movingPairs(hand, movingLinks(hand, drives.speeds()));
    }
    if (drives.isRunning())
    {
        result.status = ToiStatus::IterationLimit;
    }
    result.positions = drives.positions();
    result.stops = drives.stops();
    return result;
}

grasp::CloseHand discreteEngine(LinkProximity& proximity, const DiscreteOptions& options)
{
    return [&proximity, options](const HandModel& hand,
                                 const GraspObject& /*object*/,
                                 const Eigen::Isometry3d& X_WH,
                                 const std::vector<double>& positions,
                                 const grasp::ClosingOptions& /*options*/)
    { return discreteClosing(proximity, hand, X_WH, positions, options); };
}

double postureDifference(const HandModel& hand,
                         std::span<const double> a,
                         std::span<const double> b)
{
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
    {
        const bool slides = hand.robot.tree.links[i].joint.type == JointType::Prismatic;
        largest = std::max(largest, (slides ? 10.0 : 1.0) * std::abs(a[i] - b[i]));
    }
    return largest;
}
}  // namespace bullet_ccd::benchmarks
