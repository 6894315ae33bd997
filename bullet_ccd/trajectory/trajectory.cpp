#include "bullet_ccd/trajectory/trajectory.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace bullet_ccd
{
namespace
{
constexpr int kHighestDegree = 5;

bool allFinite(const std::vector<double>& values)
{
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// A motion of the tree in which everything rests at 0.
JointMotion restingMotion(const KinematicTree& tree, const Eigen::Isometry3d& X_WR)
{
    JointMotion motion{.root = restAt(X_WR),
                       .positions = std::vector<double>(tree.size(), 0.0),
                       .rates = std::vector<double>(tree.size(), 0.0)};
    for (const Link& link : tree.links)
    {
        if (link.joint.type == JointType::Spherical)
        {
            motion.balls.resize(tree.size());
        }
    }
    return motion;
}

/// Joints that follow others take their paths from them.
void followDrivers(const KinematicTree& tree, JointMotion& motion)
{
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(tree.size()); ++link)
    {
        const Joint& joint = tree.links[static_cast<std::size_t>(link)].joint;
        if (joint.mimicOf == kNone)
        {
            continue;
        }
        JointPath path = motion.path(joint.mimicOf);
        for (double& coefficient : path.c)
        {
            coefficient *= joint.mimicMultiplier;
        }
        path.c[0] += joint.mimicOffset;
        motion.setPath(link, path);
    }
}

/// From p0 to p1 with the derivatives v and a at both ends, all per step.
JointPath hermitePath(double p0, double v0, double p1, double v1)
{
    const double way = p1 - p0;
    return {{p0, v0, 3.0 * way - 2.0 * v0 - v1, v0 + v1 - 2.0 * way}};
}

JointPath quinticPath(double p0, double v0, double a0, double p1, double v1, double a1)
{
    const double way = p1 - p0 - v0 - 0.5 * a0;
    const double speed = v1 - v0 - a0;
    const double bend = a1 - a0;
    return {{p0,
             v0,
             0.5 * a0,
             10.0 * way - 4.0 * speed + 0.5 * bend,
             -15.0 * way + 7.0 * speed - bend,
             6.0 * way - 3.0 * speed + 0.5 * bend}};
}

void checkWaypoints(const KinematicTree& tree, std::span<const Waypoint> waypoints)
{
    require(waypoints.size() >= 2,
            "trajectory: " + std::to_string(waypoints.size()) + " waypoints: give two or more");
    for (std::size_t i = 0; i < waypoints.size(); ++i)
    {
        const Waypoint& waypoint = waypoints[i];
        const std::string where = "trajectory: waypoint " + std::to_string(i) + ": ";
        const auto fits = [&](const std::vector<double>& values)
        { return values.size() == tree.size() || values.empty(); };
        require(waypoint.positions.size() == tree.size() && fits(waypoint.velocities) &&
                    fits(waypoint.accelerations),
                where + "give one position for each of the " + std::to_string(tree.size()) +
                    " links, and as many velocities and accelerations, or none");
        require(std::isfinite(waypoint.time) && allFinite(waypoint.positions) &&
                    allFinite(waypoint.velocities) && allFinite(waypoint.accelerations),
                where + "a number is NaN or infinite");
        require(i == 0 || waypoint.time > waypoints[i - 1].time,
                where + "its time, " + std::to_string(waypoint.time) +
                    " s, is not after that of the waypoint before");
    }
}

JointMotion segmentBetween(const KinematicTree& tree,
                           const JointMotion& rest,
                           const Waypoint& from,
                           const Waypoint& to)
{
    const bool isCubic = !from.velocities.empty() && !to.velocities.empty();
    const bool isQuintic = isCubic && !from.accelerations.empty() && !to.accelerations.empty();
    const double h = to.time - from.time;
    JointMotion motion = rest;
    if (isCubic)
    {
        motion.curves.resize(tree.size());
    }
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const double p0 = from.positions[i];
        const double p1 = to.positions[i];
        JointPath path{{p0, p1 - p0}};
        if (isQuintic)
        {
            path = quinticPath(p0,
                               h * from.velocities[i],
                               h * h * from.accelerations[i],
                               p1,
                               h * to.velocities[i],
                               h * h * to.accelerations[i]);
        }
        else if (isCubic)
        {
            path = hermitePath(p0, h * from.velocities[i], p1, h * to.velocities[i]);
        }
        motion.setPath(static_cast<std::int32_t>(i), path);
    }
    followDrivers(tree, motion);
    return motion;
}

/// Value of the blossom (polar form) of a spline at `degree` arguments: de Boor's algorithm with
/// one argument for each round. With all arguments equal it is the spline itself, and with those of
/// both ends of an interval it gives the Bernstein coefficients there.
/// @param interval index k of the knots k, k + 1 between which the piece lies
double blossom(const JointSpline& spline,
               std::size_t interval,
               std::size_t joint,
               std::span<const double> arguments)
{
    const auto degree = static_cast<std::size_t>(spline.degree);
    std::array<double, kHighestDegree + 1> d{};
    for (std::size_t i = 0; i <= degree; ++i)
    {
        d[i] = spline.controlPoints[interval - degree + i][joint];
    }
    for (std::size_t round = 1; round <= degree; ++round)
    {
        for (std::size_t i = degree; i >= round; --i)
        {
            const double low = spline.knots[interval - degree + i];
            const double high = spline.knots[interval + 1 + i - round];
            const double part = (arguments[round - 1] - low) / (high - low);
            d[i] = std::lerp(d[i - 1], d[i], part);  // of equals itself: what rests, rests
        }
    }
    return d[degree];
}

/// The piece between two knots as a polynomial over [0, 1].
JointPath splinePiece(const JointSpline& spline, std::size_t interval, std::size_t joint)
{
    const auto degree = static_cast<std::size_t>(spline.degree);
    std::array<double, kHighestDegree> arguments{};
    arguments.fill(spline.knots[interval]);
    std::array<double, kHighestDegree + 1> b{};
    for (std::size_t i = 0; i <= degree; ++i)
    {
        b[i] = blossom(spline, interval, joint, arguments);
        if (i < degree)
        {
            arguments[i] = spline.knots[interval + 1];
        }
    }
    // Coefficient k is the k-th difference of b at 0, times the binomial of the degree over k.
    JointPath path;
    double binomial = 1.0;
    for (std::size_t k = 0; k <= degree; ++k)
    {
        path.c[k] = binomial * b[0];
        for (std::size_t i = 0; i + k < degree; ++i)
        {
            b[i] = b[i + 1] - b[i];
        }
        binomial *= double(degree - k) / double(k + 1);
    }
    return path;
}

void checkTimes(const Trajectory& trajectory)
{
    const auto& times = trajectory.times;
    require(!trajectory.segments.empty() && times.size() == trajectory.segments.size() + 1,
            "trajectory: " + std::to_string(trajectory.segments.size()) + " segments and " +
                std::to_string(times.size()) +
                " times: give one segment at least, and one more "
                "time than segments");
    for (std::size_t i = 1; i < times.size(); ++i)
    {
        require(times[i] > times[i - 1] && std::isfinite(times[i] - times[i - 1]),
                [&]
                {
                    return "trajectory: time " + std::to_string(i) + ", " +
                           std::to_string(times[i]) + " s, is not after the one before";
                });
    }
}

/// What a joint may jump by from the end of a segment to the begin of the next one [rad or m], of a
/// path with coefficients of at most 1: decimals of a file.
constexpr double kLargestJump = 1e-8;

/// The joint that jumps from one segment to the next, or kNone.
std::int32_t jumpBetween(const JointMotion& before, const JointMotion& after)
{
    for (std::size_t i = 0; i < before.positions.size(); ++i)
    {
        const JointPath path = before.path(static_cast<std::int32_t>(i));
        double scale = 1.0;  // at() rounds in proportion to what it adds up
        for (const double coefficient : path.c)
        {
            scale = std::max(scale, std::abs(coefficient));
        }
        if (!(std::abs(path.at(1.0) - after.positions[i]) <= kLargestJump * scale))
        {
            return static_cast<std::int32_t>(i);
        }
    }
    return kNone;
}

void checkSpline(const KinematicTree& tree, const JointSpline& spline)
{
    require(spline.degree >= 1 && spline.degree <= kHighestDegree,
            "spline: the degree is " + std::to_string(spline.degree) + ": give 1 to 5");
    const std::size_t points = spline.controlPoints.size();
    const auto degree = static_cast<std::size_t>(spline.degree);
    require(points > degree && spline.knots.size() == points + degree + 1,
            "spline: " + std::to_string(points) + " control points and " +
                std::to_string(spline.knots.size()) + " knots of degree " + std::to_string(degree) +
                ": give more control points than the degree, and degree + 1 more knots");
    require(allFinite(spline.knots) && std::is_sorted(spline.knots.begin(), spline.knots.end()) &&
                spline.knots[degree] < spline.knots[points],
            "spline: knots must be finite, must not decrease, and must span some time");
    for (std::size_t k = degree + 1; k < points; ++k)
    {
        const double knot = spline.knots[k];
        const bool isInside = knot > spline.knots[degree] && knot < spline.knots[points];
        require(!isInside || knot < spline.knots[k + degree],
                "spline: knot " + std::to_string(k) + ", " + std::to_string(knot) +
                    " s, is there more than " + std::to_string(degree) +
                    " times, so that the spline may jump: give it at most degree times");
    }
    for (const std::vector<double>& point : spline.controlPoints)
    {
        require(point.size() == tree.size() && allFinite(point),
                "spline: a control point needs one finite number for each of the " +
                    std::to_string(tree.size()) + " links");
    }
}
}  // namespace

Trajectory trajectoryThrough(const KinematicTree& tree,
                             const Eigen::Isometry3d& X_WR,
                             std::span<const Waypoint> waypoints)
{
    checkWaypoints(tree, waypoints);
    const JointMotion rest = restingMotion(tree, X_WR);
    Trajectory trajectory{.times = {waypoints[0].time}, .segments = {}};
    for (std::size_t i = 0; i + 1 < waypoints.size(); ++i)
    {
        trajectory.times.push_back(waypoints[i + 1].time);
        trajectory.segments.push_back(segmentBetween(tree, rest, waypoints[i], waypoints[i + 1]));
    }
    return trajectory;
}

Trajectory splineTrajectory(const KinematicTree& tree,
                            const Eigen::Isometry3d& X_WR,
                            const JointSpline& spline)
{
    checkSpline(tree, spline);
    JointMotion rest = restingMotion(tree, X_WR);
    if (spline.degree > 1)
    {
        rest.curves.resize(tree.size());
    }
    const auto degree = static_cast<std::size_t>(spline.degree);
    Trajectory trajectory{.times = {spline.knots[degree]}, .segments = {}};
    for (std::size_t k = degree; k < spline.controlPoints.size(); ++k)
    {
        if (!(spline.knots[k] < spline.knots[k + 1]))
        {
            continue;
        }
        JointMotion motion = rest;
        for (std::size_t i = 0; i < tree.size(); ++i)
        {
            motion.setPath(static_cast<std::int32_t>(i), splinePiece(spline, k, i));
        }
        followDrivers(tree, motion);
        trajectory.times.push_back(spline.knots[k + 1]);
        trajectory.segments.push_back(std::move(motion));
    }
    return trajectory;
}

std::vector<double> positionsAt(const Trajectory& trajectory, double time)
{
    checkTimes(trajectory);
    const auto& times = trajectory.times;
    const auto after = std::upper_bound(times.begin() + 1, times.end() - 1, time);
    const auto k = static_cast<std::size_t>(after - times.begin()) - 1;
    const double t = std::clamp((time - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0);
    const JointMotion& motion = trajectory.segments[k];
    std::vector<double> positions;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(motion.positions.size()); ++i)
    {
        positions.push_back(motion.path(i).at(t));
    }
    return positions;
}

void checkTrajectory(const Trajectory& trajectory)
{
    checkTimes(trajectory);
    for (std::size_t k = 1; k < trajectory.segments.size(); ++k)
    {
        const JointMotion& before = trajectory.segments[k - 1];
        const JointMotion& after = trajectory.segments[k];
        if (before.positions.size() != after.positions.size())
        {
            continue;  // refused by the query of that segment
        }
        const std::int32_t joint = jumpBetween(before, after);
        require(joint == kNone,
                [&]
                {
                    return "trajectory: the joint above link " + std::to_string(joint) +
                           " jumps at " + std::to_string(trajectory.times[k]) +
                           " s, from segment " + std::to_string(k - 1) +
                           " to the next: let each begin where the last one ends";
                });
    }
}
}  // namespace bullet_ccd
