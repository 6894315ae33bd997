#include "grasp/task/task_legs.h"

#include <algorithm>
#include <array>
#include <cmath>

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

void RobotBody::carry(const ArmRobot& robot,
                      const GraspObject& object,
                      const Eigen::Isometry3d& X_HO)
{
    const auto carried = static_cast<std::int32_t>(tree.size());
    tree.links.push_back({.name = object.name, .parent = robot.handRoot, .X_PL0 = X_HO});
    linkTrees.push_back(&object.tree);
    for (std::int32_t link = 0; link < robot.handRoot; ++link)
    {
        if (linkTrees[static_cast<std::size_t>(link)] != nullptr)
        {
            selfPairs.emplace_back(link, carried);
        }
    }
}

namespace
{
/// Peaks of s(t) = 10 t^3 - 15 t^4 + 6 t^5, which goes from rest to rest in one unit of time.
constexpr double kPeakSpeed = 1.875;
constexpr double kPeakAcceleration = 5.7735026918962582;  // 10 / sqrt(3)
constexpr double kShortest = 1e-3;                        // of a motion [s]

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

std::string certifyLeg(const RobotBody& body,
                       const Eigen::Isometry3d& X_WR,
                       const NamedSurroundings& around,
                       TaskLeg& leg,
                       double margin,
                       ToiWorkspace& work)
{
    leg.clearance = kEnoughClearance;
    if (leg.waypoints.size() < 2)
    {
        return {};
    }
    std::vector<Waypoint> waypoints = leg.waypoints;
    for (Waypoint& waypoint : waypoints)  // of what is carried, too
    {
        waypoint.positions.resize(body.tree.size(), 0.0);
        waypoint.velocities.resize(body.tree.size(), 0.0);
        waypoint.accelerations.resize(body.tree.size(), 0.0);
    }
    const Trajectory trajectory = trajectoryThrough(body.tree, X_WR, waypoints);
    const TrajectoryToiResult toi = trajectoryToi(body.body(),
                                                  around.environment,
                                                  trajectory,
                                                  {.toi = {.tolerance = kLegTolerance,
                                                           .minimumSeparation = margin,
                                                           .strategy = ToiStrategy::Interval}},
                                                  std::span(&work, 1));
    if (toi.status != ToiStatus::Separated)
    {
        return touchText(body, around, toi, trajectory);
    }
    leg.clearance = leastDistance(body.body(),
                                  around.bodies,
                                  trajectory,
                                  {.tolerance = kLegTolerance, .enough = kEnoughClearance},
                                  std::span(&work, 1))
                        .distance;
    return {};
}
}  // namespace bullet_ccd::grasp
