#include "benchmarks/grasp/closing_verdict.h"

#include "benchmarks/closing/discrete_closing.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/closing/closing_drives.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using grasp::ClosingResult;
using grasp::HandModel;
using grasp::StopEvent;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kSameTime = 1e-3;   // of two stops: a step of a fine sweep [s]
constexpr double kFirstStep = 1e-9;  // of the look at a way [s]
constexpr double kGrowth = 1.3;
constexpr double kLargestStep = 2e-3;  // [s]

/// When a closing stopped the link; infinite if it did not.
double stopOf(const ClosingResult& closing, std::int32_t link)
{
    const auto found = std::find_if(closing.stops.begin(),
                                    closing.stops.end(),
                                    [&](const StopEvent& stop) { return stop.link == link; });
    return found == closing.stops.end() ? kNever : found->time;
}

std::set<std::int32_t> stoppedLinks(const ClosingResult& closing)
{
    std::set<std::int32_t> links;
    for (const StopEvent& stop : closing.stops)
    {
        links.insert(stop.link);
    }
    return links;
}

/// The earliest stop of one that is not one of the other.
struct Parting
{
    std::int32_t link = kNone;
    double time = kNever;
    bool byFirst = false;
};

Parting partingOf(const ClosingResult& first, const ClosingResult& other)
{
    Parting parting;
    const auto look = [&](const ClosingResult& stopped, const ClosingResult& wentOn, bool byFirst)
    {
        for (const StopEvent& stop : stopped.stops)
        {
            if (stop.time < parting.time && stopOf(wentOn, stop.link) > stop.time + kSameTime)
            {
                parting = {.link = stop.link, .time = stop.time, .byFirst = byFirst};
            }
        }
    };
    look(first, other, true);
    look(other, first, false);
    return parting;
}

/// Distance of a link from the object and from the links that it is paired with.
double gapOf(const PosedClosing& start, const std::vector<double>& positions, std::int32_t link)
{
    const HandModel& hand = start.hand;
    const std::vector<Isometry3d> X_WL = linkPoses(hand.robot.tree, start.X_WH, positions);
    const auto at = [](std::int32_t index) { return static_cast<std::size_t>(index); };
    const SsvTree* tree = hand.linkTrees[at(link)];
    if (tree == nullptr)
    {
        return kNever;
    }
    double gap = treeDistance(*tree, start.object.tree, X_WL[at(link)], kNever).distance;
    for (const auto& [a, b] : hand.selfPairs)
    {
        if (a == link || b == link)
        {
            gap = std::min(gap,
                           treeDistance(*hand.linkTrees[at(a)],
                                        *hand.linkTrees[at(b)],
                                        X_WL[at(b)].inverse() * X_WL[at(a)],
                                        gap)
                               .distance);
        }
    }
    return gap;
}

/// True if the closing gets into something after the time, before all its joints rest.
bool goesInside(const PosedClosing& start, const ClosingResult& closing, double time)
{
    double step = kFirstStep;
    std::vector<double> before;
    for (double at = time + step;; at += step)
    {
        const std::vector<double> positions = positionsDuring(start, closing.stops, at);
        if (positions == before)
        {
            return false;
        }
        if (isInside(start, positions))
        {
            return true;
        }
        before = positions;
        step = std::min(kGrowth * step, kLargestStep);
    }
}
}  // namespace

const char* toString(ClosingVerdict verdict)
{
    constexpr std::array<const char*, kClosingVerdicts> kNames{
        "alike", "the other passes", "the first passes", "touches", "unexplained"};
    return kNames[static_cast<std::size_t>(verdict)];
}

std::vector<double> positionsDuring(const PosedClosing& start,
                                    std::span<const StopEvent> stops,
                                    double time)
{
    grasp::ClosingDrives drives(start.hand, start.open);
    for (const StopEvent& stop : stops)
    {
        if (stop.time > time)
        {
            break;
        }
        drives.advanceTo(stop.time);
        drives.stopLink(stop.link, stop.time, stop.byObject);
    }
    drives.advanceTo(time);
    return drives.positions();
}

bool isInside(const PosedClosing& start, const std::vector<double>& positions)
{
    return grasp::handOverlaps(start.hand, start.object, start.X_WH, positions) ||
           !start.check.at(start.X_WH, positions).clean();
}

double largestStopGap(const PosedClosing& start, const ClosingResult& closing)
{
    double largest = 0.0;
    for (const StopEvent& stop : closing.stops)
    {
        largest = std::max(largest, gapOf(start, closing.positions, stop.link));
    }
    return largest;
}

ClosingVerdict compareClosings(const PosedClosing& start,
                               const ClosingResult& first,
                               const ClosingResult& other,
                               const ClosingLikeness& likeness)
{
    if (postureDifference(start.hand, first.positions, other.positions) <= likeness.angle &&
        (!likeness.sameLinks || stoppedLinks(first) == stoppedLinks(other)))
    {
        return ClosingVerdict::Alike;
    }
    const Parting parting = partingOf(first, other);
    if (parting.link == kNone)
    {
        return ClosingVerdict::Unexplained;
    }
    const ClosingResult& stopped = parting.byFirst ? first : other;
    const ClosingResult& wentOn = parting.byFirst ? other : first;
    if (goesInside(start, wentOn, parting.time))
    {
        return parting.byFirst ? ClosingVerdict::OtherPasses : ClosingVerdict::FirstPasses;
    }
    const std::vector<double> there = positionsDuring(start, stopped.stops, parting.time);
    return gapOf(start, there, parting.link) <= likeness.reach ? ClosingVerdict::Touches
                                                               : ClosingVerdict::Unexplained;
}
}  // namespace bullet_ccd::benchmarks
