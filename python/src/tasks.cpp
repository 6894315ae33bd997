// Tasks of an arm with a hand. A plan travels as its JSON object, as grasp/task/README.md lists it.
#include "bullet_ccd/bullet_ccd.h"
#ifdef BULLET_CCD_HAS_TASKS
#include "grasp/task/plan_file.h"
#endif

#include "python/src/arrays.h"
#include "python/src/grasps.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"
#include "python/src/robots.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <pybind11/stl.h>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace bullet_ccd::python
{
namespace
{
#ifdef BULLET_CCD_HAS_TASKS
/// A name, a mesh and where it rests.
using NamedBodies = std::vector<std::tuple<std::string, std::shared_ptr<SsvTree>, py::object>>;

StopCondition within(double seconds, const std::atomic<bool>& stop)
{
    StopCondition condition{.isCancelled = &stop};
    if (seconds > 0.0)
    {
        condition.deadline = StopCondition::Clock::now() +
                             std::chrono::duration_cast<StopCondition::Clock::duration>(
                                 std::chrono::duration<double>(seconds));
    }
    return condition;
}

py::tuple pickPlace(const Robot& arm,
                    const Hand& hand,
                    const Object& object,
                    const py::object& objectPose,
                    const py::object& target,
                    const py::object& targetSize,
                    const NamedBodies& obstacles,
                    const std::map<std::string, double>& start,
                    const py::object& rootPose,
                    const std::string& flange,
                    const py::object& mount,
                    std::int64_t candidates,
                    int tries,
                    double approach,
                    double lift,
                    double acceleration,
                    const std::optional<double>& mass,
                    std::uint64_t seed,
                    double timeLimit)
{
    const grasp::ArmRobot robot =
        grasp::mountHand(arm.model, hand.model, flange, poseOf(mount, "mount"));
    const DoubleArray size = doublesOf(targetSize, "target_size");
    checkShape(size, {2}, "target_size");
    std::vector<RigidBody> bodies;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < obstacles.size(); ++i)
    {
        const auto& [name, tree, pose] = obstacles[i];
        const std::string argument = "obstacles[" + std::to_string(i) + "]";
        if (tree == nullptr)
        {
            throw py::type_error(argument + ": expected a name, a Mesh and a pose");
        }
        bodies.push_back({.tree = tree.get(), .motion = restAt(poseOf(pose, argument.c_str()))});
        names.push_back(name);
    }
    const grasp::PickPlaceTask task{
        .hand = hand.model,
        .robot = robot,
        .X_WR = poseOf(rootPose, "root_pose"),
        .start = grasp::startPositions(
            robot, std::vector<std::pair<std::string, double>>(start.begin(), start.end())),
        .object = object.model,
        .X_WO = poseOf(objectPose, "object_pose"),
        .obstacles = bodies,
        .obstacleNames = names,
        .target = {.center = vectorOf(target, "target"), .size = {size.at(0), size.at(1)}}};
    grasp::PickPlaceOptions options{.graspsTried = tries,
                                    .approach = approach,
                                    .lift = lift,
                                    .acceleration = acceleration,
                                    .seed = seed};
    options.grasps.candidates = candidates;
    options.grasps.seed = seed;
    options.grasps.mass = mass;
    grasp::PickPlacePlan plan;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        options.stop = within(timeLimit, stop);
        plan = grasp::planPickPlace(task, options);
    };
    runInterruptibly(work);
    std::ostringstream json;
    std::ostringstream yaml;
    grasp::writePlanJson(json, task, plan);
    if (plan.solved)
    {
        grasp::writePlanYaml(yaml, task, plan);
    }
    return py::make_tuple(json.str(), yaml.str());
}
#else
py::tuple pickPlace(const py::args& /*all*/, const py::kwargs& /*named*/)
{
    throw std::runtime_error(
        "pick_place: this build has no tasks, which need OMPL: "
        "run tools/install_dependencies --planning and build again");
}
#endif
}  // namespace

void addTasks(py::module_& module)
{
#ifdef BULLET_CCD_HAS_TASKS
    const grasp::PickPlaceOptions options;
    module.def("pick_place",
               &pickPlace,
               py::arg("arm").none(false),
               py::arg("hand").none(false),
               py::arg("object").none(false),
               py::arg("object_pose"),
               py::arg("target"),
               py::arg("target_size"),
               py::kw_only(),
               py::arg("obstacles") = NamedBodies(),
               py::arg("start") = py::dict(),
               py::arg("root_pose") = py::none(),
               py::arg("flange") = "",
               py::arg("mount") = py::none(),
               py::arg("candidates") = options.grasps.candidates,
               py::arg("tries") = options.graspsTried,
               py::arg("approach") = options.approach,
               py::arg("lift") = options.lift,
               py::arg("acceleration") = options.acceleration,
               py::arg("mass") = py::none(),
               py::arg("seed") = options.seed,
               py::arg("time_limit") = 0.0);
#else
    module.def("pick_place", &pickPlace);
#endif
}
}  // namespace bullet_ccd::python
