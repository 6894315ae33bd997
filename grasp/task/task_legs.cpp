#include "grasp/task/task_legs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace bullet_ccd::grasp
{
void NamedSurroundings::add(const SsvTree& tree,
                            const Eigen::Isometry3d& X_W,
                            const std::string& name)
{
    bodies.push_back({.tree = &tree, .motion = restAt(X_W)});
    names.push_back(name);
}

RobotBody::RobotBody(const ArmRobot& robot)
    : tree(robot.tree), linkTrees(robot.linkTrees), selfPairs(robot.selfPairs)
{
}

RobotBody::RobotBody(const HandModel& robot)
    : tree(robot.robot.tree), linkTrees(robot.linkTrees), selfPairs(robot.selfPairs)
{
}

void RobotBody::carry(const ArmRobot& robot,
                      const GraspObject& object,
                      const Eigen::Isometry3d& X_HO)
{
    std::vector<std::int32_t> arm(static_cast<std::size_t>(robot.handRoot));
    std::iota(arm.begin(), arm.end(), 0);
    carry(robot.handRoot, arm, object, X_HO);
}

void RobotBody::carry(std::int32_t link,
                      const std::vector<std::int32_t>& tested,
                      const GraspObject& object,
                      const Eigen::Isometry3d& X_LO)
{
    const auto carried = static_cast<std::int32_t>(tree.size());
    tree.links.push_back({.name = object.name, .parent = link, .X_PL0 = X_LO});
    linkTrees.push_back(&object.tree);
    for (const std::int32_t other : tested)
    {
        if (linkTrees[static_cast<std::size_t>(other)] != nullptr)
        {
            selfPairs.emplace_back(other, carried);
        }
    }
}

namespace
{
/// Peaks of s(t) = 10 t^3 - 15 t^4 + 6 t^5, which goes from rest to rest in one unit of time.
constexpr double kPeakSpeed = 1.875;
constexpr double kPeakAcceleration = 5.7735026918962582;  // 10 / sqrt(3)
constexpr double kShortest = 1e-3;                        // of a motion [s]

/// The hand moves straight in steps of this [m], in each of which no joint may jump [rad or m].
constexpr double kStraightStep = 0.02;
constexpr double kLargestJump = 0.3;

double durationOf(const KinematicTree& tree,
                  const std::vector<double>& from,
                  const std::vector<double>& to,
                  const PickPlaceOptions& options)
{
    double duration = 0.0;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const double way = std::abs(to[i] - from[i]);
        if (way > 0.0)
        {
            const double limit = tree.links[i].joint.maxVelocity;
            const double speed = std::isfinite(limit) && limit > 0.0 ? limit : options.freeSpeed;
            duration = std::max({duration,
                                 kShortest,
                                 kPeakSpeed * way / speed,
                                 std::sqrt(kPeakAcceleration * way / options.acceleration)});
        }
    }
    return duration;
}

std::string touchText(const RobotBody& body,
                      const NamedSurroundings& around,
                      const TrajectoryToiResult& toi,
                      const Trajectory& trajectory)
{
    if (toi.contacts.empty())
    {
        return "the query gave up";
    }
    const LinkContact& contact = toi.contacts.front();
    const auto nameOf = [&](std::int32_t link)
    { return body.tree.links[static_cast<std::size_t>(link)].name; };
    const double length = trajectory.times.back() - trajectory.times.front();
    const double part = (toi.time - trajectory.times.front()) / std::max(length, 1e-12);
    return nameOf(contact.link) + " touches " +
           (contact.obstacle != kNone ? around.names[static_cast<std::size_t>(contact.obstacle)]
                                      : nameOf(contact.otherLink)) +
           " at " + std::to_string(static_cast<int>(std::lround(100.0 * part))) + " % of the way";
}
}  // namespace

std::vector<Waypoint> timedWaypoints(const KinematicTree& tree,
                                     const std::vector<std::vector<double>>& positions,
                                     double begin,
                                     const PickPlaceOptions& options)
{
    const std::vector<double> rest(tree.size(), 0.0);
    std::vector<Waypoint> waypoints;
    double time = begin;
    for (const std::vector<double>& q : positions)
    {
        if (!waypoints.empty())
        {
            const double duration = durationOf(tree, waypoints.back().positions, q, options);
            if (duration == 0.0)
            {
                continue;
            }
            time += duration;
        }
        waypoints.push_back(
            {.time = time, .positions = q, .velocities = rest, .accelerations = rest});
    }
    return waypoints;
}

std::vector<JointPositions> straightPath(const ArmKinematics& arm,
                                         const JointPositions& start,
                                         const Eigen::Vector3d& shift)
{
    Eigen::Isometry3d X_WH = arm.poseAt(start);
    const auto steps =
        std::max(1, static_cast<int>(std::ceil(shift.norm() / kStraightStep - 1e-6)));
    std::vector<JointPositions> path{start};
    const Eigen::Vector3d from = X_WH.translation();
    for (int i = 1; i <= steps; ++i)
    {
        X_WH.translation() = from + shift * (double(i) / steps);
        const auto next = arm.follow(X_WH, path.back(), kLargestJump);
        if (!next)
        {
            return {};
        }
        path.push_back(*next);
    }
    return path;
}

std::vector<double> closingTimes(const ClosingSpans& spans)
{
    std::vector<double> times{0.0};
    for (const ClosingSpan& span : spans.joints)
    {
        times.insert(times.end(), {span.begin, span.end});
    }
    std::ranges::sort(times);
    return times;
}

std::vector<double> closingAt(const ClosingSpans& spans,
                              const std::vector<double>& closed,
                              double time)
{
    std::vector<double> q = spans.from;
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        const auto [begin, end] = spans.joints[i];
        const double part =
            time >= end ? 1.0 : std::clamp((time - begin) / (end - begin), 0.0, 1.0);
        q[i] = part == 1.0 ? closed[i] : std::lerp(q[i], closed[i], part);
    }
    return q;
}

void followOn(std::vector<TaskLeg>& legs)
{
    double begin = 0.0;
    for (TaskLeg& leg : legs)
    {
        for (Waypoint& waypoint : leg.waypoints)
        {
            waypoint.time += begin;
        }
        begin = leg.waypoints.back().time;
    }
}

namespace
{
/// Of a leg with two waypoints or more.
Trajectory trajectoryOf(const RobotBody& body, const Eigen::Isometry3d& X_WR, const TaskLeg& leg)
{
    std::vector<Waypoint> waypoints = leg.waypoints;
    for (Waypoint& waypoint : waypoints)  // of what is carried, too
    {
        waypoint.positions.resize(body.tree.size(), 0.0);
        waypoint.velocities.resize(body.tree.size(), 0.0);
        waypoint.accelerations.resize(body.tree.size(), 0.0);
    }
    return trajectoryThrough(body.tree, X_WR, waypoints);
}
}  // namespace

std::string touchedOnLeg(const RobotBody& body,
                         const Eigen::Isometry3d& X_WR,
                         const NamedSurroundings& around,
                         const TaskLeg& leg,
                         double margin,
                         ToiWorkspace& work)
{
    if (leg.waypoints.size() < 2)
    {
        return {};
    }
    const Trajectory trajectory = trajectoryOf(body, X_WR, leg);
    const TrajectoryToiResult toi = trajectoryToi(body.body(),
                                                  around.environment,
                                                  trajectory,
                                                  {.toi = {.tolerance = kLegTolerance,
                                                           .minimumSeparation = margin,
                                                           .strategy = ToiStrategy::Interval}},
                                                  std::span(&work, 1));
    return toi.status == ToiStatus::Separated ? std::string()
                                              : touchText(body, around, toi, trajectory);
}

double clearanceOf(const RobotBody& body,
                   const Eigen::Isometry3d& X_WR,
                   const NamedSurroundings& around,
                   const TaskLeg& leg,
                   ToiWorkspace& work)
{
    return leg.waypoints.size() < 2
               ? kEnoughClearance
               : leastDistance(body.body(),
                               around.bodies,
                               trajectoryOf(body, X_WR, leg),
                               {.tolerance = kLegTolerance, .enough = kEnoughClearance},
                               std::span(&work, 1))
                     .distance;
}

std::string certifyLeg(const RobotBody& body,
                       const Eigen::Isometry3d& X_WR,
                       const NamedSurroundings& around,
                       TaskLeg& leg,
                       double margin,
                       ToiWorkspace& work)
{
    std::string touched = touchedOnLeg(body, X_WR, around, leg, margin, work);
    leg.clearance = touched.empty() ? clearanceOf(body, X_WR, around, leg, work) : kEnoughClearance;
    return touched;
}
}  // namespace bullet_ccd::grasp
