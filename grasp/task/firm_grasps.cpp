#include "grasp/task/firm_grasps.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/planner/plan_candidate.h"
#include "grasp/planner/weight_margin.h"
#include "grasp/quality/object_mass.h"
#include "grasp/squeeze/squeeze.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tbb/parallel_for.h>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// Of the efforts, beside the torques of the squeeze.
constexpr double kReserve = 0.1;
/// What holds so many times the mass of the object is not looked for at other depths.
constexpr double kFirmEnough = 6.0;
/// How far the hand is drawn back from where it first touched something [m].
constexpr std::array kDrawnBack{0.0, 3e-3, 6e-3, 0.012, 0.02, 0.03, 0.04, 0.055};
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

namespace
{
/// Of the depths along the approach, that at which the grasp holds most, if there is one.
std::optional<Grasp> firmest(const HandModel& hand,
                             const GraspObject& object,
                             std::span<const RigidBody> obstacles,
                             const Grasp& grasp,
                             const PickPlaceOptions& options,
                             const ArrivesAt& arrives)
{
    const Preshape& preshape = *findPreshape(hand, grasp.preshape);
    const std::vector<double>& open = preshape.positions;
    const RigidBody taken{.tree = &object.tree, .motion = restAt(Eigen::Isometry3d::Identity())};
    const double enough = kFirmEnough * massOf(object, options.grasps.mass).mass;
    std::vector<RigidBody> bodies{taken};
    bodies.insert(bodies.end(), obstacles.begin(), obstacles.end());
    const Environment environment(bodies);
    const CloseHand close = kinematicClosing(obstacles);
    PenetrationCheck check(hand, object);
    ToiWorkspace work;
    CandidateContext context{.hand = hand,
                             .object = object,
                             .environment = environment,
                             .options = options.grasps,
                             .close = close,
                             .check = check,
                             .work = work};
    Grasp approached;
    approached.candidate = grasp.candidate;
    approached.preshape = grasp.preshape;
    approached.source = grasp.source;
    approached.approach_W = grasp.approach_W;
    std::optional<Grasp> best;
    bool isAsked = false;
    for (const double back : kDrawnBack)
    {
        Eigen::Isometry3d X_WH = grasp.X_WStart;
        X_WH.translation() += (grasp.approachDistance - back) * grasp.approach_W;
        const auto isOpenClear = [&](const Eigen::Isometry3d& X)
        {
            return isClear(hand, X, open, std::span(&taken, 1), options.margin) &&
                   isClear(hand, X, open, obstacles, options.margin);
        };
        if (!isOpenClear(X_WH))
        {
            continue;
        }
        if (!isAsked)
        {
            isAsked = true;
            Grasp at = grasp;
            at.X_WH = X_WH;
            if (!arrives(at))
            {
                return std::nullopt;
            }
        }
        approached.X_WStart = X_WH;
        Grasp drawn = closeCentred(approached, X_WH, open, context);
        rejectPenetration(drawn, context);
        if (drawn.reject != RejectReason::None || !isOpenClear(drawn.X_WH) ||
            !isClear(hand, drawn.X_WH, drawn.positions, obstacles, options.margin))
        {
            continue;
        }
        drawn.X_WStart = drawn.X_WH;
        drawn.quality.largestMass = massHeldBySqueeze(hand, object, drawn, options);
        if (!best || *drawn.quality.largestMass > *best->quality.largestMass)
        {
            best = std::move(drawn);
        }
        if (*best->quality.largestMass >= enough)
        {
            break;
        }
    }
    return best;
}
}  // namespace

std::vector<Grasp> firmGrasps(const HandModel& hand,
                              const GraspObject& object,
                              std::span<const RigidBody> obstacles,
                              const std::vector<Grasp>& candidates,
                              const PickPlaceOptions& options,
                              const ArrivesAt& arrives)
{
    const double mass = massOf(object, options.grasps.mass).mass;
    std::vector<std::optional<Grasp>> found(candidates.size());
    tbb::parallel_for(std::size_t{0},
                      candidates.size(),
                      [&](std::size_t i)
                      {
                          if (!options.stop.isDue() && candidates[i].approachDistance > 0.0)
                          {
                              found[i] =
                                  firmest(hand, object, obstacles, candidates[i], options, arrives);
                          }
                      });
    std::vector<Grasp> firm;
    for (std::optional<Grasp>& grasp : found)
    {
        if (grasp && *grasp->quality.largestMass >= options.holds * mass)
        {
            firm.push_back(*std::move(grasp));
        }
    }
    std::ranges::stable_sort(firm,
                             [](const Grasp& a, const Grasp& b)
                             { return a.quality.largestMass > b.quality.largestMass; });
    return firm;
}
}  // namespace bullet_ccd::grasp
