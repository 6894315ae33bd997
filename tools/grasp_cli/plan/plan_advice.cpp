#include "tools/grasp_cli/plan/plan_advice.h"

#include "grasp/approach/approach_sampler.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <string_view>

namespace bullet_ccd::tools
{
namespace
{
using grasp::Grasp;
using grasp::RejectReason;

/// That the object is too large for the hand, or else `otherwise`.
std::string ofSize(const grasp::HandModel& hand,
                   const grasp::GraspObject& object,
                   const std::string& otherwise)
{
    const grasp::ApproachShapes shapes = grasp::approachShapes(hand, object);
    const double opening = std::ranges::max(shapes.hands, {}, &grasp::OpenHand::opening).opening;
    const double thickness = shapes.object.extents().minCoeff();
    return thickness <= opening
               ? otherwise
               : fmt::format(
                     "the object is {:.0f} mm thick where it is thinnest, the hand opens "
                     "to {:.0f} mm: is the unit right (--object-scale)?",
                     1e3 * thickness,
                     1e3 * opening);
}

std::string adviceFor(RejectReason reason,
                      const grasp::HandModel& hand,
                      const grasp::GraspObject& object,
                      bool hasTable)
{
    switch (reason)
    {
        case RejectReason::OverlapAtStart:
            return hasTable
                       ? "start poses overlap the table or the object: decrease --max-tilt, or "
                         "increase --standoff"
                       : "start poses overlap the object: increase --standoff";
        case RejectReason::SelfOverlap:
            return "the hand overlaps itself: look at the preshapes (grasp hand) and at the pairs "
                   "of links that are tested (grasp hand check)";
        case RejectReason::NoApproachHit:
            return "the hand stops before the object: increase --reach";
        case RejectReason::TooFewContacts:
            return ofSize(hand,
                          object,
                          "fingers end beside the object: look at the preshapes and at the grasp "
                          "frame (grasp hand)");
        case RejectReason::Obstacle:
            return hasTable ? "the table or an obstacle is in the way: decrease --max-tilt, or try "
                              "another --approach-from"
                            : "obstacles are in the way: try --table-top or another "
                              "--approach-from";
        case RejectReason::OutOfReach:
            return "the arm does not bring the hand there: try another --robot-pose";
        case RejectReason::NoForceClosure:
            return ofSize(hand,
                          object,
                          "fingers touch the object but do not oppose each other: look at the "
                          "thumb in the preshapes and at the grasp frame (grasp hand), or try "
                          "another --approach-from");
        case RejectReason::None:
        case RejectReason::Penetration:
        case RejectReason::IterationLimit:
            break;
    }
    return {};
}
}  // namespace

std::string epsilonClasses(std::span<const Grasp> grasps)
{
    int firm = 0;
    int fair = 0;
    int marginal = 0;
    for (const Grasp& grasp : grasps)
    {
        if (grasp.reject == RejectReason::None)
        {
            const std::string_view itsClass = grasp::epsilonClass(grasp.quality.epsilon);
            ++(itsClass == "firm" ? firm : itsClass == "fair" ? fair : marginal);
        }
    }
    return fmt::format(
        "{} firm (epsilon >= 0.2), {} fair (>= 0.05), {} marginal", firm, fair, marginal);
}

std::string planAdvice(const grasp::HandModel& hand,
                       const grasp::GraspObject& object,
                       std::span<const Grasp> grasps,
                       bool hasTable)
{
    std::map<RejectReason, std::size_t> counts;
    for (const Grasp& grasp : grasps)
    {
        ++counts[grasp.reject];
    }
    if (grasps.empty() || 10 * counts[RejectReason::None] >= grasps.size())
    {
        return {};
    }
    counts.erase(RejectReason::None);
    const auto most =
        std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
    return adviceFor(most->first, hand, object, hasTable);
}
}  // namespace bullet_ccd::tools
