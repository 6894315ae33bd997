#include "python/src/interruptible.h"
#include "python/src/module.h"
#include "python/src/pickled.h"
#include "python/src/robots.h"

#include <limits>
#include <optional>
#include <pybind11/stl.h>
#include <thread>
#include <utility>

namespace bullet_ccd::python
{
namespace
{
/// A trajectory with the robot that it is for, which it keeps alive.
struct RobotTrajectory
{
    std::shared_ptr<const Robot> robot;
    Trajectory path;
};

/// Row k of an array of joint positions, velocities or accelerations, with an entry per link.
std::vector<double> rowOf(const Robot& robot, const DoubleArray& rows, py::ssize_t k)
{
    std::vector<double> values(robot.model.tree.size(), 0.0);
    for (std::size_t j = 0; j < robot.movable.size(); ++j)
    {
        values[static_cast<std::size_t>(robot.movable[j])] =
            rows.at(k, static_cast<py::ssize_t>(j));
    }
    return values;
}

DoubleArray rowsOf(const Robot& robot, const py::handle& value, py::ssize_t count, const char* name)
{
    const DoubleArray rows = doublesOf(value, name);
    checkShape(rows, {count, static_cast<py::ssize_t>(robot.movable.size())}, name);
    return rows;
}

RobotTrajectory through(std::shared_ptr<Robot> robot,
                        const py::object& times,
                        const py::object& positions,
                        const py::object& velocities,
                        const py::object& accelerations,
                        const py::object& root)
{
    const DoubleArray at = doublesOf(times, "times");
    checkShape(at, {-1}, "times");
    const py::ssize_t count = at.shape(0);
    const DoubleArray p = rowsOf(*robot, positions, count, "positions");
    std::vector<Waypoint> waypoints;
    for (py::ssize_t k = 0; k < count; ++k)
    {
        waypoints.push_back({.time = at.at(k), .positions = rowOf(*robot, p, k)});
    }
    const auto add = [&](const py::object& value, const char* name, auto Waypoint::*member)
    {
        if (value.is_none())
        {
            return;
        }
        const DoubleArray rows = rowsOf(*robot, value, count, name);
        for (py::ssize_t k = 0; k < count; ++k)
        {
            waypoints[static_cast<std::size_t>(k)].*member = rowOf(*robot, rows, k);
        }
    };
    add(velocities, "velocities", &Waypoint::velocities);
    add(accelerations, "accelerations", &Waypoint::accelerations);
    Trajectory path = trajectoryThrough(robot->model.tree, poseOf(root, "root"), waypoints);
    return {.robot = std::move(robot), .path = std::move(path)};
}

RobotTrajectory spline(std::shared_ptr<Robot> robot,
                       const py::object& knots,
                       const py::object& controlPoints,
                       int degree,
                       const py::object& root)
{
    const DoubleArray at = doublesOf(knots, "knots");
    checkShape(at, {-1}, "knots");
    const DoubleArray rows = rowsOf(*robot, controlPoints, -1, "control_points");
    JointSpline joints{.degree = degree,
                       .knots = std::vector<double>(at.data(), at.data() + at.size()),
                       .controlPoints = {}};
    for (py::ssize_t k = 0; k < rows.shape(0); ++k)
    {
        joints.controlPoints.push_back(rowOf(*robot, rows, k));
    }
    Trajectory path = splineTrajectory(robot->model.tree, poseOf(root, "root"), joints);
    return {.robot = std::move(robot), .path = std::move(path)};
}

/// Positions in the order of Robot.joint_names.
DoubleArray positionsAtTime(const RobotTrajectory& trajectory, double time)
{
    const std::vector<double> positions = positionsAt(trajectory.path, time);
    const std::vector<std::int32_t>& movable = trajectory.robot->movable;
    DoubleArray values(static_cast<py::ssize_t>(movable.size()));
    for (std::size_t j = 0; j < movable.size(); ++j)
    {
        values.mutable_at(static_cast<py::ssize_t>(j)) =
            positions[static_cast<std::size_t>(movable[j])];
    }
    return values;
}

/// One scratch memory for each thread; 0: one per core.
std::vector<ToiWorkspace> workspaces(int jobs)
{
    if (jobs < 0)
    {
        throw py::value_error("jobs: " + std::to_string(jobs) +
                              " is no number of threads: give 0 for one per core, or more");
    }
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    return std::vector<ToiWorkspace>(jobs > 0 ? std::min(static_cast<unsigned>(jobs), 4 * cores)
                                              : cores);
}

struct TrajectoryAnswer : ArticulatedAnswer
{
    std::optional<std::int32_t> segment;
};

TrajectoryAnswer trajectoryToiOf(const RobotTrajectory& trajectory,
                                 const Obstacles& obstacles,
                                 const std::vector<LinkNames>& selfPairs,
                                 double tolerance,
                                 double minimumSeparation,
                                 std::int64_t maxIterations,
                                 double timeLimit,
                                 int jobs)
{
    const Robot& robot = *trajectory.robot;
    const RobotScene scene(robot, obstacles, selfPairs);
    std::vector<ToiWorkspace> scratch = workspaces(jobs);
    TrajectoryToiResult result;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        ToiOptions options{.tolerance = tolerance,
                           .minimumSeparation = minimumSeparation,
                           .maxIterations = maxIterations,
                           .stop = stopAfter(timeLimit)};
        options.stop.isCancelled = &stop;
        const Environment environment(scene.obstacles);
        result =
            trajectoryToi(scene.body(), environment, trajectory.path, {.toi = options}, scratch);
    };
    runInterruptibly(work);
    TrajectoryAnswer answer;
    answer.status = result.status;
    answer.time = result.time;
    answer.contacts = namedContacts(robot, result.contacts);
    answer.segment = result.segment == kNone ? std::nullopt : std::optional(result.segment);
    return answer;
}

/// With names in place of indices.
struct NamedLeastDistance : TrajectoryLeastDistance
{
    std::optional<std::string> linkName;
    std::optional<std::string> otherLinkName;
};

NamedLeastDistance named(const Robot& robot, const TrajectoryLeastDistance& least)
{
    return {least, robot.linkName(least.link), robot.linkName(least.otherLink)};
}

NamedLeastDistance trajectoryLeastDistance(const RobotTrajectory& trajectory,
                                           const Obstacles& obstacles,
                                           const std::vector<LinkNames>& selfPairs,
                                           double tolerance,
                                           double enough,
                                           double timeLimit,
                                           int jobs)
{
    const Robot& robot = *trajectory.robot;
    const RobotScene scene(robot, obstacles, selfPairs);
    std::vector<ToiWorkspace> scratch = workspaces(jobs);
    TrajectoryLeastDistance least;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        LeastDistanceOptions options{
            .tolerance = tolerance, .enough = enough, .stop = stopAfter(timeLimit)};
        options.stop.isCancelled = &stop;
        least = leastDistance(scene.body(), scene.obstacles, trajectory.path, options, scratch);
    };
    runInterruptibly(work);
    return named(robot, least);
}

NamedLeastDistance articulatedLeastDistance(const Robot& robot,
                                            const py::object& start,
                                            const py::object& end,
                                            const Obstacles& obstacles,
                                            const py::object& rootStart,
                                            const py::object& rootEnd,
                                            const std::vector<LinkNames>& selfPairs,
                                            double tolerance,
                                            double enough,
                                            double timeLimit)
{
    const JointMotion motion = jointMotionOf(robot, start, end, rootStart, rootEnd);
    const RobotScene scene(robot, obstacles, selfPairs);
    TrajectoryLeastDistance least;
    static_cast<ArticulatedLeastDistance&>(least) = askInterruptibly(
        stopAfter(timeLimit),
        [&](const StopCondition& stop)
        {
            const LeastDistanceOptions options{
                .tolerance = tolerance, .enough = enough, .stop = stop};
            ToiWorkspace work;
            return leastDistance(scene.body(&motion), scene.obstacles, options, work);
        });
    least.seconds = least.time;
    return named(robot, least);
}

void addLeastDistances(py::module_& module)
{
    const auto index = [](std::int32_t value)
    { return value == kNone ? std::nullopt : std::optional(value); };
    using Least = NamedLeastDistance;
    py::class_<Least>(module, "RobotLeastDistance")
        .def(pickled<Least,
                     &Least::status,
                     &Least::distance,
                     &Least::found,
                     &Least::seconds,
                     &Least::segment,
                     &Least::linkName,
                     &Least::otherLinkName,
                     &Least::obstacle,
                     &Least::pointA,
                     &Least::pointB,
                     &Least::normal>())
        .def_readonly("status", &Least::status)
        .def_readonly("distance", &Least::distance)
        .def_readonly("found", &Least::found)
        .def_readonly("time", &Least::seconds)
        .def_property_readonly("segment",
                               [index](const Least& least) { return index(least.segment); })
        .def_readonly("link", &Least::linkName)
        .def_readonly("other_link", &Least::otherLinkName)
        .def_property_readonly("obstacle",
                               [index](const Least& least) { return index(least.obstacle); })
        .def_property_readonly("point_link",
                               [](const Least& least) { return arrayOf(least.pointA); })
        .def_property_readonly("point_other",
                               [](const Least& least) { return arrayOf(least.pointB); })
        .def_property_readonly("normal", [](const Least& least) { return arrayOf(least.normal); });
    const LeastDistanceOptions options;
    module.def("articulated_least_distance",
               &articulatedLeastDistance,
               py::arg("robot").none(false),
               py::arg("start"),
               py::arg("end"),
               py::arg("obstacles"),
               py::kw_only(),
               py::arg("root_start") = py::none(),
               py::arg("root_end") = py::none(),
               py::arg("self_pairs") = py::list(),
               py::arg("tolerance") = options.tolerance,
               py::arg("enough") = options.enough,
               py::arg("time_limit") = std::numeric_limits<double>::infinity());
    module.def("trajectory_least_distance",
               &trajectoryLeastDistance,
               py::arg("trajectory").none(false),
               py::arg("obstacles"),
               py::kw_only(),
               py::arg("self_pairs") = py::list(),
               py::arg("tolerance") = options.tolerance,
               py::arg("enough") = options.enough,
               py::arg("time_limit") = std::numeric_limits<double>::infinity(),
               py::arg("jobs") = 0);
}
}  // namespace

void addTrajectories(py::module_& module)
{
    py::class_<RobotTrajectory>(module, "Trajectory")
        .def_static("through",
                    &through,
                    py::arg("robot").none(false),
                    py::arg("times"),
                    py::arg("positions"),
                    py::arg("velocities") = py::none(),
                    py::arg("accelerations") = py::none(),
                    py::kw_only(),
                    py::arg("root") = py::none())
        .def_static("spline",
                    &spline,
                    py::arg("robot").none(false),
                    py::arg("knots"),
                    py::arg("control_points"),
                    py::kw_only(),
                    py::arg("degree") = JointSpline{}.degree,
                    py::arg("root") = py::none())
        .def_property_readonly("times",
                               [](const RobotTrajectory& trajectory)
                               {
                                   const std::vector<double>& times = trajectory.path.times;
                                   return DoubleArray(static_cast<py::ssize_t>(times.size()),
                                                      times.data());
                               })
        .def("at", &positionsAtTime, py::arg("time"))
        .def("__len__",
             [](const RobotTrajectory& trajectory) { return trajectory.path.segments.size(); });
    py::class_<TrajectoryAnswer, ArticulatedAnswer>(module, "TrajectoryToiResult")
        .def(pickled<TrajectoryAnswer,
                     &TrajectoryAnswer::status,
                     &TrajectoryAnswer::time,
                     &TrajectoryAnswer::contacts,
                     &TrajectoryAnswer::segment>())
        .def_readonly("segment", &TrajectoryAnswer::segment);
    const ToiOptions options;
    module.def("trajectory_toi",
               &trajectoryToiOf,
               py::arg("trajectory").none(false),
               py::arg("obstacles"),
               py::kw_only(),
               py::arg("self_pairs") = py::list(),
               py::arg("tolerance") = options.tolerance,
               py::arg("minimum_separation") = options.minimumSeparation,
               py::arg("max_iterations") = options.maxIterations,
               py::arg("time_limit") = std::numeric_limits<double>::infinity(),
               py::arg("jobs") = 0);
    addLeastDistances(module);
}
}  // namespace bullet_ccd::python
