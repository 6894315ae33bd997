#include "grasp/task/task_legs.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <list>
#include <numeric>
#include <set>

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

namespace
{
/// The vertices of marked triangles, each once.
std::vector<Eigen::Vector3d> verticesOf(const SsvTree& tree, std::span<const std::uint8_t> marks)
{
    std::set<std::int32_t> used;
    for (std::size_t i = 0; i < marks.size(); ++i)
    {
        if (marks[i] != 0)
        {
            const auto& triangle = tree.mesh().triangles[i];
            used.insert(triangle.begin(), triangle.end());
        }
    }
    std::vector<Eigen::Vector3d> vertices;
    for (const std::int32_t k : used)
    {
        vertices.push_back(tree.mesh().vertices[static_cast<std::size_t>(k)]);
    }
    return vertices;
}

/// Bound of the second derivative of a point of the last link over s in [0, 1], if all joints move
/// linearly in s from one configuration to the other: that of chains of turns and slides.
double bendOfLastLink(const KinematicTree& tree,
                      const std::vector<double>& from,
                      const std::vector<double>& to,
                      double radius)
{
    double reach = radius;  // of the point from any joint of its chain
    double turns = 0.0;
    double slides = 0.0;
    for (std::int32_t link = static_cast<std::int32_t>(tree.size()) - 1; link != kNone;
         link = tree.links[static_cast<std::size_t>(link)].parent)
    {
        const auto i = static_cast<std::size_t>(link);
        const Link& each = tree.links[i];
        reach += each.X_PL0.translation().norm();
        if (each.joint.type == JointType::Prismatic)
        {
            reach += std::max(std::abs(from[i]), std::abs(to[i]));
            slides += std::abs(to[i] - from[i]);
        }
        else
        {
            turns += std::abs(to[i] - from[i]);
        }
    }
    return turns * turns * reach + 2.0 * turns * slides;
}

/// True if all points of the last link rise at all times of the motion from one configuration to
/// another in which all joints move linearly.
bool allRise(const RobotBody& body,
             const Eigen::Isometry3d& X_WR,
             const std::vector<double>& from,
             const std::vector<double>& to,
             const std::vector<Eigen::Vector3d>& points)
{
    constexpr int kSteps = 128;
    double radius = 0.0;
    for (const Eigen::Vector3d& point : points)
    {
        radius = std::max(radius, point.norm());
    }
    // A difference of heights is the rate of rising somewhere in its step, and the rate changes by
    // no more than this until the end of the step.
    const double change = bendOfLastLink(body.tree, from, to, radius) / kSteps;
    std::vector<double> q(from.size());
    std::vector<double> heights(points.size(), -std::numeric_limits<double>::infinity());
    for (int step = 0; step <= kSteps; ++step)
    {
        for (std::size_t i = 0; i < q.size(); ++i)
        {
            q[i] = std::lerp(from[i], to[i], double(step) / kSteps);
        }
        const Eigen::Isometry3d X_WO = linkPoses(body.tree, X_WR, q).back();
        for (std::size_t i = 0; i < points.size(); ++i)
        {
            const double height = (X_WO * points[i]).z();
            if (!(kSteps * (height - heights[i]) > change))
            {
                return false;
            }
            heights[i] = height;
        }
    }
    return true;
}
}  // namespace

Parting certifyParting(const RobotBody& body,
                       const Eigen::Isometry3d& X_WR,
                       const NamedSurroundings& around,
                       const TaskLeg& leg,
                       double reach,
                       double overlap,
                       ToiWorkspace& work)
{
    TaskLeg begin = leg;
    begin.waypoints.resize(std::min<std::size_t>(begin.waypoints.size(), 2));
    if (begin.waypoints.size() < 2)
    {
        return {};
    }
    const Trajectory trajectory = trajectoryOf(body, X_WR, begin);
    const std::vector<double> from = positionsAt(trajectory, trajectory.times.front());
    const std::vector<double> to = positionsAt(trajectory, trajectory.times.back());
    const SsvTree& object = *body.linkTrees.back();
    const Eigen::Isometry3d X_WO = linkPoses(body.tree, X_WR, from).back();
    Parting parting;
    std::list<PairMask> masks;
    std::vector<LinkMask> linkMasks;
    for (std::size_t i = 0; i < around.bodies.size(); ++i)
    {
        const SsvTree& other = *around.bodies[i].tree;
        const Eigen::Isometry3d& X_WB = around.bodies[i].motion.X_W0;
        const Eigen::Isometry3d X_BO = X_WB.inverse() * X_WO;
        const double near = std::nextafter(reach, 2.0 * reach);
        if (treeDistance(object, other, X_BO, near).distance > reach)
        {
            continue;
        }
        const PairMask& mask =
            masks.emplace_back(maskNear(object, other, std::span(&X_BO, 1), overlap));
        linkMasks.push_back({.link = static_cast<std::int32_t>(body.tree.size()) - 1,
                             .obstacle = static_cast<std::int32_t>(i),
                             .mask = &mask});
        parting.from.push_back(around.names[i]);
        const std::vector<Eigen::Vector3d> points = verticesOf(object, mask.marksA());
        double lowest = std::numeric_limits<double>::infinity();
        double highest = -lowest;
        for (const Eigen::Vector3d& point : points)
        {
            lowest = std::min(lowest, (X_WO * point).z());
        }
        for (const Eigen::Vector3d& point : verticesOf(other, mask.marksB()))
        {
            highest = std::max(highest, (X_WB * point).z());
        }
        if (highest > lowest + overlap || !allRise(body, X_WR, from, to, points))
        {
            parting.objection = body.tree.links.back().name + " does not part from " +
                                around.names[i] + ", on which it stands or leans";
            return parting;
        }
    }
    if (linkMasks.empty())
    {
        return parting;
    }
    ArticulatedBody moving = body.body();
    moving.masks = linkMasks;
    const TrajectoryToiResult toi =
        trajectoryToi(moving,
                      around.environment,
                      trajectory,
                      {.toi = {.tolerance = kLegTolerance, .strategy = ToiStrategy::Interval}},
                      std::span(&work, 1));
    if (toi.status != ToiStatus::Separated)
    {
        parting.objection = touchText(body, around, toi, trajectory);
    }
    return parting;
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
