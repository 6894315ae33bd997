#include "grasp/trial/two_hands_execution.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/trial/driven_robot.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kHoldTime = 1.0;     // [s]
constexpr double kMostTurn = 0.0873;  // [rad]
}  // namespace

LiftResult executeLift(const TwoHandTask& task,
                       const TwoHandPlan& plan,
                       const ExecutionOptions& options)
{
    require(!plan.legs.empty() && plan.squeeze.exists(), "execution: the plan has no legs");
    require(options.rate > 0.0 && std::isfinite(options.rate),
            "execution: the rate must be positive: give steps per second");
    const HandModel& whole = task.arms.whole;
    const KinematicTree& tree = whole.robot.tree;
    // The frame of the simulation is that of the object at its start.
    const Eigen::Isometry3d X_OW = plan.X_WOStart.inverse();
    TrialWorld world(whole,
                     task.object,
                     {.mass = massOf(task.object, options.mass).mass,
                      .friction = options.friction,
                      .margin = 0.5 * options.skin,
                      .stiffness = options.skinStiffness},
                     X_OW,
                     plan.legs.front().waypoints.front().positions);
    for (const RigidBody& obstacle : task.obstacles)
    {
        world.addBody(*obstacle.tree, X_OW * obstacle.motion.X_W0, 0.0);
    }
    DrivenRobot robot(world, tree, X_OW.linear().col(2), options.rate, options.stop);
    const std::vector<std::int32_t> joints = independentJoints(tree);
    for (std::size_t j = 0; j < joints.size(); ++j)
    {
        robot.pressBy(plan.squeeze, j, static_cast<std::size_t>(joints[j]));
    }
    LiftResult result;
    result.leastDistance = std::numeric_limits<double>::infinity();
    robot.onSample(
        [&]
        {
            result.leastDistance = leastDistanceNow(
                world, whole, X_OW, task.object.tree, task.obstacles, result.leastDistance);
        });
    for (const TaskLeg& leg : plan.legs)
    {
        robot.follow(leg);
        if (leg.name == "close")
        {
            robot.press(0.0, 1.0, kSqueezeTime, leg.waypoints.back().positions);
        }
    }
    const std::vector<double>& end = plan.legs.back().waypoints.back().positions;
    robot.hold(end, kHoldTime);

    const Eigen::Isometry3d X_WOEnd =
        linkPoses(tree,
                  Eigen::Isometry3d::Identity(),
                  end)[static_cast<std::size_t>(task.arms.handRoot(0))] *
        plan.X_HO;
    const Eigen::Vector3d& center = task.object.centerOfMass;
    const Eigen::Vector3d now = plan.X_WOStart * world.objectCenter();
    result.risen = (now - plan.X_WOStart * center).z();
    result.missed = (now - X_WOEnd * center).norm();
    result.turned = Eigen::AngleAxisd(world.objectPose().linear()).angle();
    result.stopped = robot.isStopped();
    result.seconds = robot.seconds();
    const HoldingSolver::Counters counters = world.solverCounters();
    result.inexact = double(counters.failures) / double(std::max(1L, counters.solves));
    result.reason = result.stopped                               ? "stopped"
                    : result.leastDistance <= 0.0                ? "something was penetrated"
                    : !(result.missed <= options.placeTolerance) ? "the object was not lifted"
                    : !(result.turned <= kMostTurn)              ? "the object has turned"
                                                                 : "";
    result.succeeded = result.reason.empty();
    return result;
}
}  // namespace bullet_ccd::grasp
