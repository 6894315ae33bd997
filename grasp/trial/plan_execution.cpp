#include "grasp/trial/plan_execution.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/quality/object_mass.h"
#include "grasp/sim/trial_world.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/trial/driven_robot.h"
#include "grasp/trial/grasp_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kReleaseTime = 0.25;       // [s]
constexpr double kSettleTime = 1.0;         // [s]
constexpr double kRehearsedWay = 3e-3;      // [m]
constexpr double kRehearsedTurn = 0.07;     // [rad]
constexpr double kRehearsedFriction = 0.8;  // of that which is counted on

ExecutionOptions withMass(ExecutionOptions options, const GraspObject& object)
{
    options.mass = massOf(object, options.mass).mass;
    return options;
}

class PlanExecution
{
public:
    PlanExecution(const PickPlaceTask& task,
                  const PickPlacePlan& plan,
                  const ExecutionOptions& options)
        : m_task(task),
          m_plan(plan),
          m_options(withMass(options, task.object)),
          m_whole(wholeRobot(task.robot, task.hand)),
          m_X_OW(plan.X_WOStart.inverse()),
          m_squeeze(squeezeOf(task.hand,
                              plan.grasp,
                              {.mass = m_options.mass,
                               .centerOfMass = task.object.centerOfMass,
                               .friction = options.friction,
                               .firmness = options.firmness})),
          m_world(m_whole,
                  task.object,
                  {.mass = *m_options.mass,
                   .friction = options.friction,
                   .margin = 0.5 * options.skin,
                   .stiffness = options.skinStiffness},
                  m_X_OW * task.X_WR,
                  plan.legs.front().waypoints.front().positions),
          m_robot(m_world, task.robot.tree, m_X_OW.linear().col(2), options.rate, options.stop)
    {
        for (std::size_t i = 0; i < task.obstacles.size(); ++i)
        {
            m_world.addBody(
                *task.obstacles[i].tree, m_X_OW * task.obstacles[i].motion.X_W0, massOf(i));
        }
        m_result.leastDistance = std::numeric_limits<double>::infinity();
        m_result.grip = m_squeeze.normalForce;
        const std::vector<std::int32_t> hand = independentJoints(task.hand.robot.tree);
        for (std::size_t j = 0; m_squeeze.exists() && j < hand.size(); ++j)
        {
            m_robot.pressBy(m_squeeze, j, static_cast<std::size_t>(task.robot.ofHand(hand[j])));
        }
        m_robot.onSample(
            [this]
            {
                m_result.leastDistance = leastDistanceNow(m_world,
                                                          m_whole,
                                                          m_X_OW * m_task.X_WR,
                                                          m_task.object.tree,
                                                          m_task.obstacles,
                                                          m_result.leastDistance);
            });
    }

    ExecutionResult run()
    {
        if (!m_squeeze.exists())
        {
            m_result.reason = "the grasp cannot squeeze the object: " + m_squeeze.reason;
            return m_result;
        }
        for (std::size_t i = 0; i < m_plan.legs.size(); ++i)
        {
            const TaskLeg& leg = m_plan.legs[i];
            if (leg.name == "open")
            {
                m_robot.press(1.0, 0.0, kReleaseTime, leg.waypoints.front().positions);
            }
            m_robot.follow(leg);
            watch(i);
            if (leg.name == "close")
            {
                m_robot.press(0.0, 1.0, kSqueezeTime, leg.waypoints.back().positions);
            }
        }
        m_robot.hold(m_plan.legs.back().waypoints.back().positions, kSettleTime);
        judge();
        return m_result;
    }

private:
    [[nodiscard]] double massOf(std::size_t obstacle) const
    {
        return m_options.obstacleMasses.empty() ? 0.0 : m_options.obstacleMasses[obstacle];
    }

    /// Notes the first leg at whose end the object is not where the leg brings it.
    void watch(std::size_t leg)
    {
        const TaskLeg& done = m_plan.legs[leg];
        const std::vector<Eigen::Isometry3d> X_O =
            linkPoses(m_task.robot.tree, m_X_OW * m_task.X_WR, done.waypoints.back().positions);
        const Eigen::Isometry3d X_OExpected =
            done.carries ? X_O[static_cast<std::size_t>(m_task.robot.handRoot)] * m_plan.X_HO
                         : m_X_OW * restingPose(m_plan, leg);
        const double off =
            (m_world.objectCenter() - X_OExpected * m_task.object.centerOfMass).norm();
        if (m_lostDuring.empty() && !(off <= m_options.placeTolerance))
        {
            m_lostDuring = done.name;
        }
    }

    [[nodiscard]] std::string lostText() const
    {
        return m_lostDuring.empty() ? "" : ": it came off its way during " + m_lostDuring;
    }

    void judge()
    {
        const Eigen::Vector3d place = m_plan.X_WOEnd * m_task.object.centerOfMass;
        m_result.missed = (m_plan.X_WOStart * m_world.objectCenter() - place).norm();
        std::string moved;
        for (std::size_t i = 0; i < m_task.obstacles.size(); ++i)
        {
            if (massOf(i) > 0.0)
            {
                const Eigen::Vector3d center = m_task.obstacles[i].tree->origin();
                const double way = (m_world.bodyPose(i) * center -
                                    m_X_OW * m_task.obstacles[i].motion.X_W0 * center)
                                       .norm();
                moved = way > m_result.othersMoved ? m_task.obstacleNames[i] : moved;
                m_result.othersMoved = std::max(m_result.othersMoved, way);
            }
        }
        m_result.reason = m_robot.isStopped()             ? "stopped"
                          : m_result.leastDistance <= 0.0 ? "something was penetrated"
                          : !(m_result.missed <= m_options.placeTolerance)
                              ? "the object is not where it is to be" + lostText()
                          : m_result.othersMoved > m_options.othersTolerance ? moved + " was moved"
                                                                             : "";
        m_result.stopped = m_robot.isStopped();
        m_result.seconds = m_robot.seconds();
        const HoldingSolver::Counters counters = m_world.solverCounters();
        m_result.inexact = double(counters.failures) / double(std::max(1L, counters.solves));
        m_result.succeeded = m_result.reason.empty();
    }

    const PickPlaceTask& m_task;
    const PickPlacePlan& m_plan;
    const ExecutionOptions m_options;
    HandModel m_whole;
    Eigen::Isometry3d m_X_OW;  // the frame of the simulation is that of the object at its start
    Squeeze m_squeeze;
    TrialWorld m_world;
    DrivenRobot m_robot;
    std::string m_lostDuring;
    ExecutionResult m_result;
};
}  // namespace

std::function<std::string(const Grasp&)> rehearsal(const PickPlaceTask& task,
                                                   const ExecutionOptions& options)
{
    return [&task, options = withMass(options, task.object)](const Grasp& grasp)
    {
        using Kind = TrialPhase::Kind;
        TrialProtocol lift{.name = "rehearsal", .start = TrialStart::Table};
        lift.phases = {{.kind = Kind::Lift, .time = 0.75, .amount = 0.1},
                       {.kind = Kind::Load, .time = 0.25, .direction = {0.5, 0.0, -1.0}},
                       {.kind = Kind::Load, .time = 0.25, .direction = {-0.5, 0.0, -1.0}},
                       {.kind = Kind::Load, .time = 0.25, .direction = {0.0, 0.5, -1.0}},
                       {.kind = Kind::Load, .time = 0.25, .direction = {0.0, -0.5, -1.0}}};
        lift.heldWay = kRehearsedWay;
        lift.heldTurn = kRehearsedTurn;
        const TrialResult result =
            runTrial(task.hand,
                     task.object,
                     grasp,
                     lift,
                     {.squeeze = {.mass = options.mass,
                                  .friction = options.friction,
                                  .firmness = options.firmness},
                      .friction = kRehearsedFriction * options.friction,
                      .rate = options.rate,
                      .up = task.X_WO.linear().transpose() * Eigen::Vector3d::UnitZ(),
                      .skin = options.skin,
                      .skinStiffness = options.skinStiffness,
                      .closesAsPlanned = true,
                      .stop = options.stop});
        return result.outcome == TrialOutcome::Held
                   ? std::string()
                   : "in a simulation: " + std::string(toString(result.outcome)) +
                         (result.reason.empty() ? "" : ": " + result.reason);
    };
}

ExecutionResult executePlan(const PickPlaceTask& task,
                            const PickPlacePlan& plan,
                            const ExecutionOptions& options)
{
    require(plan.solved && !plan.legs.empty(), "execution: the plan is not solved");
    require(
        options.obstacleMasses.empty() || options.obstacleMasses.size() == task.obstacles.size(),
        "execution: give one mass for each obstacle, or none");
    require(options.rate > 0.0 && std::isfinite(options.rate),
            "execution: the rate must be positive: give steps per second");
    return PlanExecution(task, plan, options).run();
}
}  // namespace bullet_ccd::grasp
