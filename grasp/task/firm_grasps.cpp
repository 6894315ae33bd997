#include "grasp/task/firm_grasps.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/planner/weight_margin.h"
#include "grasp/quality/object_mass.h"
#include "grasp/squeeze/squeeze.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// Of the efforts, beside the torques of the squeeze.
constexpr double kReserve = 0.1;
/// How far the hand is drawn back, over the margin.
constexpr std::array kDrawnBack{0.0, 1.5, 3.0, 6.0};
}  // namespace

double massHeldBySqueeze(const HandModel& hand,
                         const GraspObject& object,
                         const Grasp& grasp,
                         const PickPlaceOptions& options)
{
    const PlannerOptions& asked = options.grasps;
    const Squeeze squeeze = squeezeOf(hand,
                                      grasp,
                                      {.mass = massOf(object, asked.mass).mass,
                                       .centerOfMass = object.centerOfMass,
                                       .friction = asked.friction,
                                       .firmness = options.firmness,
                                       .efforts = asked.efforts});
    if (!squeeze.exists())
    {
        return 0.0;
    }
    std::vector<double> efforts;
    for (std::size_t j = 0; j < squeeze.torques.size(); ++j)
    {
        const double limit = squeeze.efforts[j].limit;
        efforts.push_back(std::min(limit, std::abs(squeeze.torques[j]) + kReserve * limit));
    }
    return largestMassHeld(hand, object, grasp, asked.friction, pyramidEdges(asked), efforts);
}

bool isClear(const HandModel& hand,
             const Eigen::Isometry3d& X_WH,
             const std::vector<double>& positions,
             std::span<const RigidBody> bodies,
             double margin)
{
    const std::vector<Eigen::Isometry3d> X_W = linkPoses(hand.robot.tree, X_WH, positions);
    for (std::size_t link = 0; link < X_W.size(); ++link)
    {
        for (const RigidBody& body : bodies)
        {
            if (hand.linkTrees[link] != nullptr &&
                treeDistance(*hand.linkTrees[link],
                             *body.tree,
                             body.motion.X_W0.inverse() * X_W[link],
                             margin)
                        .distance < margin)
            {
                return false;
            }
        }
    }
    return true;
}

std::vector<Grasp> firmGrasps(const HandModel& hand,
                              const GraspObject& object,
                              std::span<const RigidBody> obstacles,
                              const std::vector<Grasp>& grasps,
                              const PickPlaceOptions& options)
{
    const CloseHand close = kinematicClosing(obstacles);
    const double mass = massOf(object, options.grasps.mass).mass;
    const RigidBody taken{.tree = &object.tree, .motion = restAt(Eigen::Isometry3d::Identity())};
    std::vector<Grasp> firm;
    for (const Grasp& grasp : grasps)
    {
        if (grasp.reject != RejectReason::None || options.stop.isDue())
        {
            continue;
        }
        const Preshape& preshape = *findPreshape(hand, grasp.preshape);
        const std::vector<double>& open = preshape.positions;
        Eigen::Isometry3d X_WH = grasp.X_WH;
        const auto back = std::ranges::find_if(
            kDrawnBack,
            [&](double share)
            {
                X_WH.translation() =
                    grasp.X_WH.translation() - share * options.margin * grasp.approach_W;
                return isClear(hand, X_WH, open, std::span(&taken, 1), options.margin);
            });
        if (back == kDrawnBack.end() || !isClear(hand, X_WH, open, obstacles, options.margin))
        {
            continue;
        }
        Grasp drawn = closeAtPose(hand,
                                  object,
                                  X_WH,
                                  Eigen::Vector3d::Zero(),
                                  preshape,
                                  options.grasps,
                                  close,
                                  obstacles);
        drawn.candidate = grasp.candidate;
        drawn.source = grasp.source;
        drawn.approach_W = grasp.approach_W;
        drawn.approachDistance = grasp.approachDistance;
        if (drawn.reject != RejectReason::None ||
            !isClear(hand, X_WH, drawn.positions, obstacles, options.margin))
        {
            continue;
        }
        drawn.quality.largestMass = massHeldBySqueeze(hand, object, drawn, options);
        if (*drawn.quality.largestMass >= options.holds * mass)
        {
            firm.push_back(std::move(drawn));
        }
    }
    std::ranges::stable_sort(firm,
                             [](const Grasp& a, const Grasp& b)
                             { return a.quality.largestMass > b.quality.largestMass; });
    return firm;
}
}  // namespace bullet_ccd::grasp
