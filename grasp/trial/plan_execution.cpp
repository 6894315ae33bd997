#include "grasp/trial/plan_execution.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/quality/object_mass.h"
#include "grasp/sim/trial_world.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/trial/grasp_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kSqueezeTime = 0.5;          // [s]
constexpr double kReleaseTime = 0.25;         // [s]
constexpr double kSettleTime = 1.0;           // [s]
constexpr double kSamplesPerSecond = 60.0;
constexpr double kRehearsedWay = 3e-3;      // [m]
constexpr double kRehearsedTurn = 0.07;     // [rad]
constexpr double kRehearsedFriction = 0.8;  // of that which is counted on
/// Controllers of the arm: full effort at this error of position [rad or m], and how long a push
/// takes to fade [s].
constexpr double kArmError = 0.02;
constexpr double kFadingTime = 0.02;
constexpr double kUnlimitedSpeed = 10.0;  // of a joint without a limit [rad/s or m/s]

/// The robot as the simulation of hands takes it.
HandModel asHand(const ArmRobot& robot)
{
    HandModel whole;
    whole.robot.name = robot.name;
    whole.robot.tree = robot.tree;
    whole.linkTrees = robot.linkTrees;
    whole.selfPairs = robot.selfPairs;
    return whole;
}

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
          m_whole(asHand(task.robot)),
          m_X_OW(plan.X_WOStart.inverse()),
          m_joints(independentJoints(task.robot.tree)),
          m_squeeze(squeezeOf(task.hand,
                              plan.grasp,
                              {.mass = m_options.mass,
                               .centerOfMass = task.object.centerOfMass,
                               .friction = options.friction,
                               .firmness = options.firmness})),
          m_offsets(task.robot.tree.size(), 0.0),
          m_world(m_whole,
                  task.object,
                  {.mass = *m_options.mass,
                   .friction = options.friction,
                   .margin = 0.5 * options.skin,
                   .stiffness = options.skinStiffness},
                  m_X_OW * task.X_WR,
                  plan.legs.front().waypoints.front().positions)
    {
        for (std::size_t i = 0; i < task.obstacles.size(); ++i)
        {
            m_world.addBody(
                *task.obstacles[i].tree, m_X_OW * task.obstacles[i].motion.X_W0, massOf(i));
        }
        m_result.leastDistance = std::numeric_limits<double>::infinity();
        m_result.grip = m_squeeze.normalForce;
        setUpDrives();
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
                press(1.0, 0.0, kReleaseTime, leg.waypoints.front().positions);
            }
            follow(leg);
            watch(i);
            if (leg.name == "close")
            {
                press(0.0, 1.0, kSqueezeTime, leg.waypoints.back().positions);
            }
        }
        hold(m_plan.legs.back().waypoints.back().positions, kSettleTime);
        judge();
        return m_result;
    }

private:
    [[nodiscard]] double massOf(std::size_t obstacle) const
    {
        return m_options.obstacleMasses.empty() ? 0.0 : m_options.obstacleMasses[obstacle];
    }

    void setUpDrives()
    {
        const std::vector<std::int32_t> hand = independentJoints(m_task.hand.robot.tree);
        m_drives.resize(m_task.robot.tree.size());
        for (const std::int32_t link : m_joints)
        {
            const Joint& joint = m_task.robot.tree.links[static_cast<std::size_t>(link)].joint;
            const bool slides = joint.type == JointType::Prismatic;
            DriveSettings& drive = m_drives[static_cast<std::size_t>(link)];
            drive.effort = std::isfinite(joint.maxEffort) && joint.maxEffort > 0.0
                               ? joint.maxEffort
                               : (slides ? kUsualForce : kUsualTorque);
            drive.stiffness = drive.effort / kArmError;
            drive.maxSpeed = std::isfinite(joint.maxVelocity) && joint.maxVelocity > 0.0
                                 ? joint.maxVelocity
                                 : kUnlimitedSpeed;
        }
        for (std::size_t j = 0; m_squeeze.exists() && j < hand.size(); ++j)
        {
            const auto link = static_cast<std::size_t>(m_task.robot.ofHand(hand[j]));
            m_drives[link].effort = m_squeeze.efforts[j].limit;
            m_drives[link].stiffness = m_squeeze.stiffness[j];
            m_pressed.emplace_back(link, m_squeeze.torques[j] / m_squeeze.stiffness[j]);
        }
        for (DriveSettings& drive : m_drives)
        {
            drive.damping = kFadingTime * drive.stiffness;
        }
    }

    /// One step towards these positions, with velocities that are fed forward.
    void step(const std::vector<double>& positions, const std::vector<double>& velocities)
    {
        if (m_options.stop.isDue())
        {
            m_isStopped = true;
            return;
        }
        for (const std::int32_t joint : m_joints)
        {
            const auto i = static_cast<std::size_t>(joint);
            m_world.drive(
                joint, m_drives[i], positions[i] + m_offsets[i] + kFadingTime * velocities[i]);
        }
        const double timeStep = 1.0 / m_options.rate;
        m_world.step(timeStep,
                     m_X_OW.linear() * Eigen::Vector3d(0.0, 0.0, -kStandardGravity),
                     Eigen::Vector3d::Zero());
        m_result.seconds += timeStep;
        if (m_result.seconds * kSamplesPerSecond >= m_samples)
        {
            ++m_samples;
            look();
        }
    }

    void follow(const TaskLeg& leg)
    {
        if (leg.waypoints.size() < 2)
        {
            return;
        }
        const KinematicTree& tree = m_task.robot.tree;
        const Trajectory way = trajectoryThrough(tree, m_task.X_WR, leg.waypoints);
        const double begin = way.times.front();
        const auto steps =
            static_cast<int>(std::max(1.0, std::ceil((way.times.back() - begin) * m_options.rate)));
        std::vector<double> before = leg.waypoints.front().positions;
        for (int i = 1; i <= steps && !m_isStopped; ++i)
        {
            const std::vector<double> now = positionsAt(way, begin + i / m_options.rate);
            std::vector<double> velocities = now;
            for (std::size_t k = 0; k < now.size(); ++k)
            {
                velocities[k] = (now[k] - before[k]) * m_options.rate;
            }
            step(now, velocities);
            before = now;
        }
    }

    void hold(const std::vector<double>& positions, double seconds)
    {
        const std::vector<double> rest(positions.size(), 0.0);
        for (int i = 0; i < seconds * m_options.rate && !m_isStopped; ++i)
        {
            step(positions, rest);
        }
    }

    /// The fingers press by a share of the squeeze, which changes.
    void press(double from, double to, double seconds, const std::vector<double>& positions)
    {
        const double count = std::max(1.0, seconds * m_options.rate);
        for (int i = 1; i <= count && !m_isStopped; ++i)
        {
            const double share = std::lerp(from, to, std::min(1.0, 2.0 * i / count));
            for (const auto& [link, offset] : m_pressed)
            {
                m_offsets[link] = share * offset;
            }
            hold(positions, 0.5 / m_options.rate);  // one step
        }
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

    /// Distances of all that the plan tests, at this moment.
    void look()
    {
        const std::vector<Eigen::Isometry3d> X_O =
            linkPoses(m_task.robot.tree, m_X_OW * m_task.X_WR, m_world.positions());
        double& least = m_result.leastDistance;
        const auto pair = [&least](const SsvTree& a,
                                   const Eigen::Isometry3d& X_A,
                                   const SsvTree& b,
                                   const Eigen::Isometry3d& X_B)
        { least = treeDistance(a, b, X_B.inverse() * X_A, least).distance; };
        const SsvTree& object = m_task.object.tree;
        const std::vector<const SsvTree*>& trees = m_task.robot.linkTrees;
        for (std::size_t link = 1; link < trees.size(); ++link)
        {
            for (std::size_t i = 0; trees[link] != nullptr && i < m_task.obstacles.size(); ++i)
            {
                pair(*trees[link], X_O[link], *m_task.obstacles[i].tree, m_world.bodyPose(i));
            }
            if (trees[link] != nullptr)
            {
                pair(*trees[link], X_O[link], object, m_world.objectPose());
            }
        }
        for (std::size_t i = 0; i < m_task.obstacles.size(); ++i)
        {
            pair(object, m_world.objectPose(), *m_task.obstacles[i].tree, m_world.bodyPose(i));
        }
        for (const auto& [a, b] : m_task.robot.selfPairs)
        {
            const auto i = static_cast<std::size_t>(a);
            const auto k = static_cast<std::size_t>(b);
            pair(*trees[i], X_O[i], *trees[k], X_O[k]);
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
        m_result.reason = m_isStopped                     ? "stopped"
                          : m_result.leastDistance <= 0.0 ? "something was penetrated"
                          : !(m_result.missed <= m_options.placeTolerance)
                              ? "the object is not where it is to be" + lostText()
                          : m_result.othersMoved > m_options.othersTolerance ? moved + " was moved"
                                                                             : "";
        m_result.stopped = m_isStopped;
        const HoldingSolver::Counters counters = m_world.solverCounters();
        m_result.inexact = double(counters.failures) / double(std::max(1L, counters.solves));
        m_result.succeeded = m_result.reason.empty();
    }

    const PickPlaceTask& m_task;
    const PickPlacePlan& m_plan;
    const ExecutionOptions m_options;
    HandModel m_whole;
    Eigen::Isometry3d m_X_OW;  // the frame of the simulation is that of the object at its start
    std::vector<std::int32_t> m_joints;
    Squeeze m_squeeze;
    std::vector<DriveSettings> m_drives;                    // one entry per link
    std::vector<std::pair<std::size_t, double>> m_pressed;  // links, and their squeeze as a way
    std::vector<double> m_offsets;                          // one entry per link
    TrialWorld m_world;
    bool m_isStopped = false;
    double m_samples = 0.0;
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
