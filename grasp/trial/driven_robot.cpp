#include "grasp/trial/driven_robot.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/force/grasp_forces.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kSamplesPerSecond = 60.0;
/// Controllers of the arm: full effort at this error of position [rad or m], and how long a push
/// takes to fade [s].
constexpr double kArmError = 0.02;
constexpr double kFadingTime = 0.02;
constexpr double kUnlimitedSpeed = 10.0;  // of a joint without a limit [rad/s or m/s]
}  // namespace

DrivenRobot::DrivenRobot(TrialWorld& world,
                         const KinematicTree& tree,
                         const Eigen::Vector3d& up,
                         double rate,
                         StopCondition stop)
    : m_world(world),
      m_tree(tree),
      m_acceleration(-kStandardGravity * up),
      m_rate(rate),
      m_stop(std::move(stop)),
      m_joints(independentJoints(tree)),
      m_drives(tree.size()),
      m_offsets(tree.size(), 0.0)
{
    for (const std::int32_t link : m_joints)
    {
        const Joint& joint = tree.links[static_cast<std::size_t>(link)].joint;
        const bool slides = joint.type == JointType::Prismatic;
        DriveSettings& drive = m_drives[static_cast<std::size_t>(link)];
        drive.effort = std::isfinite(joint.maxEffort) && joint.maxEffort > 0.0
                           ? joint.maxEffort
                           : (slides ? kUsualForce : kUsualTorque);
        drive.stiffness = drive.effort / kArmError;
        drive.damping = kFadingTime * drive.stiffness;
        drive.maxSpeed = std::isfinite(joint.maxVelocity) && joint.maxVelocity > 0.0
                             ? joint.maxVelocity
                             : kUnlimitedSpeed;
    }
}

void DrivenRobot::pressBy(const Squeeze& squeeze, std::size_t j, std::size_t link)
{
    DriveSettings& drive = m_drives[link];
    drive.effort = squeeze.efforts[j].limit;
    drive.stiffness = squeeze.stiffness[j];
    drive.damping = kFadingTime * drive.stiffness;
    m_pressed.emplace_back(link, squeeze.torques[j] / squeeze.stiffness[j]);
}

/// One step towards these positions, with velocities that are fed forward.
void DrivenRobot::step(const std::vector<double>& positions, const std::vector<double>& velocities)
{
    if (m_stop.isDue())
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
    const double timeStep = 1.0 / m_rate;
    m_world.step(timeStep, m_acceleration, Eigen::Vector3d::Zero());
    m_seconds += timeStep;
    if (m_seconds * kSamplesPerSecond >= m_samples)
    {
        ++m_samples;
        if (m_look)
        {
            m_look();
        }
    }
}

void DrivenRobot::follow(const TaskLeg& leg)
{
    if (leg.waypoints.size() < 2)
    {
        return;
    }
    const Trajectory way = trajectoryThrough(m_tree, Eigen::Isometry3d::Identity(), leg.waypoints);
    const double begin = way.times.front();
    const auto steps =
        static_cast<int>(std::max(1.0, std::ceil((way.times.back() - begin) * m_rate)));
    std::vector<double> before = leg.waypoints.front().positions;
    for (int i = 1; i <= steps && !m_isStopped; ++i)
    {
        const std::vector<double> now = positionsAt(way, begin + i / m_rate);
        std::vector<double> velocities = now;
        for (std::size_t k = 0; k < now.size(); ++k)
        {
            velocities[k] = (now[k] - before[k]) * m_rate;
        }
        step(now, velocities);
        before = now;
    }
}

void DrivenRobot::hold(const std::vector<double>& positions, double seconds)
{
    const std::vector<double> rest(positions.size(), 0.0);
    for (int i = 0; i < seconds * m_rate && !m_isStopped; ++i)
    {
        step(positions, rest);
    }
}

void DrivenRobot::press(double from,
                        double to,
                        double seconds,
                        const std::vector<double>& positions)
{
    const double count = std::max(1.0, seconds * m_rate);
    for (int i = 1; i <= count && !m_isStopped; ++i)
    {
        const double share = std::lerp(from, to, std::min(1.0, 2.0 * i / count));
        for (const auto& [link, offset] : m_pressed)
        {
            m_offsets[link] = share * offset;
        }
        hold(positions, 0.5 / m_rate);  // one step
    }
}

double leastDistanceNow(const TrialWorld& world,
                        const HandModel& robot,
                        const Eigen::Isometry3d& X_OR,
                        const SsvTree& object,
                        std::span<const RigidBody> obstacles,
                        double least)
{
    const KinematicTree& tree = robot.robot.tree;
    const std::vector<Eigen::Isometry3d> X_O = linkPoses(tree, X_OR, world.positions());
    const auto pair = [&least](const SsvTree& a,
                               const Eigen::Isometry3d& X_A,
                               const SsvTree& b,
                               const Eigen::Isometry3d& X_B)
    { least = treeDistance(a, b, X_B.inverse() * X_A, least).distance; };
    std::vector<char> moves(tree.size(), 0);
    for (std::size_t link = 1; link < tree.size(); ++link)
    {
        const auto parent = static_cast<std::size_t>(tree.links[link].parent);
        moves[link] = tree.links[link].joint.isMovable() ? 1 : moves[parent];
        const SsvTree* body = robot.linkTrees[link];
        if (body == nullptr || moves[link] == 0)
        {
            continue;
        }
        for (std::size_t i = 0; i < obstacles.size(); ++i)
        {
            pair(*body, X_O[link], *obstacles[i].tree, world.bodyPose(i));
        }
        pair(*body, X_O[link], object, world.objectPose());
    }
    for (std::size_t i = 0; i < obstacles.size(); ++i)
    {
        pair(object, world.objectPose(), *obstacles[i].tree, world.bodyPose(i));
    }
    for (const auto& [a, b] : robot.selfPairs)
    {
        const auto i = static_cast<std::size_t>(a);
        const auto k = static_cast<std::size_t>(b);
        pair(*robot.linkTrees[i], X_O[i], *robot.linkTrees[k], X_O[k]);
    }
    return least;
}
}  // namespace bullet_ccd::grasp
