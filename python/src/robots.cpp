#include "python/src/robots.h"

#include "bullet_ccd/bullet_ccd.h"
#include "bullet_ccd/io.h"

#include "python/src/arrays.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"
#include "python/src/pickled.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <utility>

namespace bullet_ccd::python
{
std::vector<double> positionsOf(const Robot& robot, const py::handle& value, const char* name)
{
    std::vector<double> positions(robot.model.tree.size(), 0.0);
    for (const std::int32_t link : robot.movable)
    {
        const Joint& joint = robot.joint(link);
        positions[static_cast<std::size_t>(link)] = std::clamp(0.0, joint.lower, joint.upper);
    }
    if (py::isinstance<py::dict>(value))
    {
        for (const auto& [key, position] : value.cast<py::dict>())
        {
            const auto jointName = key.cast<std::string>();
            const std::int32_t link = robot.model.tree.findJoint(jointName);
            if (std::ranges::find(robot.movable, link) == robot.movable.end())
            {
                throw py::key_error(std::string(name) + ": " + robot.model.name +
                                    " has no joint '" + jointName + "' that moves by itself");
            }
            positions[static_cast<std::size_t>(link)] = position.cast<double>();
        }
    }
    else if (!value.is_none())
    {
        const DoubleArray array = doublesOf(value, name);
        checkShape(array, {static_cast<py::ssize_t>(robot.movable.size())}, name);
        for (std::size_t k = 0; k < robot.movable.size(); ++k)
        {
            positions[static_cast<std::size_t>(robot.movable[k])] =
                array.at(static_cast<py::ssize_t>(k));
        }
    }
    applyMimics(robot.model.tree, positions);
    return positions;
}

std::vector<RigidBody> bodiesOf(const Obstacles& obstacles, const char* argument)
{
    std::vector<RigidBody> bodies;
    for (std::size_t i = 0; i < obstacles.size(); ++i)
    {
        const std::string name = std::string(argument) + "[" + std::to_string(i) + "]";
        if (obstacles[i].first == nullptr)
        {
            throw py::type_error(name + ": expected a Mesh, but got None");
        }
        bodies.push_back({.tree = obstacles[i].first.get(),
                          .motion = motionOf(obstacles[i].second, name.c_str())});
    }
    return bodies;
}

RobotScene::RobotScene(const Robot& theRobot,
                       const Obstacles& theObstacles,
                       const std::vector<LinkNames>& selfPairs)
    : robot(theRobot), obstacles(bodiesOf(theObstacles, "obstacles"))
{
    for (const auto& [a, b] : selfPairs)
    {
        pairs.emplace_back(robot.link(a), robot.link(b));
    }
}

std::vector<NamedContact> namedContacts(const Robot& robot, std::span<const LinkContact> contacts)
{
    std::vector<NamedContact> named;
    for (const LinkContact& contact : contacts)
    {
        named.push_back({contact,
                         robot.linkName(contact.link).value_or(""),
                         robot.linkName(contact.otherLink)});
    }
    return named;
}

JointMotion jointMotionOf(const Robot& robot,
                          const py::object& start,
                          const py::object& end,
                          const py::object& rootStart,
                          const py::object& rootEnd)
{
    JointMotion motion{
        .root = motionBetween(poseOf(rootStart, "root_start"),
                              poseOf(rootEnd.is_none() ? rootStart : rootEnd, "root_end")),
        .positions = positionsOf(robot, start, "start"),
        .rates = positionsOf(robot, end, "end")};
    for (std::size_t i = 0; i < motion.rates.size(); ++i)
    {
        motion.rates[i] -= motion.positions[i];
    }
    return motion;
}

namespace
{
py::dict linkPosesOf(const Robot& robot, const py::object& positions, const py::object& root)
{
    const std::vector<Eigen::Isometry3d> poses = linkPoses(
        robot.model.tree, poseOf(root, "root"), positionsOf(robot, positions, "positions"));
    py::dict named;
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        named[py::str(robot.model.tree.links[i].name)] = arrayOf(poses[i]);
    }
    return named;
}

/// Pairs of links with geometry that no joint joins directly.
std::vector<LinkNames> selfPairNames(const Robot& robot)
{
    std::vector<LinkNames> names;
    const std::vector<Link>& links = robot.model.tree.links;
    for (const auto& [a, b] : selfPairsOf(robot.model.tree, robot.linkTrees))
    {
        const Link& linkA = links[static_cast<std::size_t>(a)];
        const Link& linkB = links[static_cast<std::size_t>(b)];
        if (linkA.parent != b && linkB.parent != a)
        {
            names.emplace_back(linkA.name, linkB.name);
        }
    }
    return names;
}

std::vector<py::tuple> limitsOf(const Robot& robot)
{
    std::vector<py::tuple> limits;
    for (const std::int32_t link : robot.movable)
    {
        limits.push_back(py::make_tuple(robot.joint(link).lower, robot.joint(link).upper));
    }
    return limits;
}

std::vector<std::string> jointNames(const Robot& robot)
{
    std::vector<std::string> names;
    for (const std::int32_t link : robot.movable)
    {
        names.push_back(robot.joint(link).name);
    }
    return names;
}

/// Names of the links above, and of the joints that join them.
py::dict linkParents(const Robot& robot)
{
    py::dict parents;
    for (const Link& link : robot.model.tree.links)
    {
        parents[py::str(link.name)] = py::cast(robot.linkName(link.parent));
    }
    return parents;
}

py::dict linkJoints(const Robot& robot)
{
    py::dict joints;
    for (const Link& link : robot.model.tree.links)
    {
        if (link.parent != kNone)
        {
            joints[py::str(link.name)] = link.joint.name;
        }
    }
    return joints;
}

std::vector<std::string> linkNames(const Robot& robot)
{
    std::vector<std::string> names;
    for (const Link& link : robot.model.tree.links)
    {
        names.push_back(link.name);
    }
    return names;
}

ArticulatedAnswer articulatedToiOf(const Robot& robot,
                                   const py::object& start,
                                   const py::object& end,
                                   const Obstacles& obstacles,
                                   const py::object& rootStart,
                                   const py::object& rootEnd,
                                   const std::vector<LinkNames>& selfPairs,
                                   double tolerance,
                                   double minimumSeparation,
                                   std::int64_t maxIterations,
                                   bool anyWithin,
                                   double timeLimit)
{
    const JointMotion motion = jointMotionOf(robot, start, end, rootStart, rootEnd);
    const RobotScene scene(robot, obstacles, selfPairs);
    const ArticulatedToiResult result = askInterruptibly(
        stopAfter(timeLimit),
        [&](const StopCondition& stop)
        {
            const ToiOptions options{.tolerance = tolerance,
                                     .minimumSeparation = minimumSeparation,
                                     .anyWithin = anyWithin,
                                     .maxIterations = maxIterations,
                                     .stop = stop};
            ToiWorkspace work;
            return articulatedToi(scene.body(&motion), scene.obstacles, options, work);
        });
    return {.status = result.status,
            .time = result.time,
            .contacts = namedContacts(robot, result.contacts)};
}

void addContactResults(py::module_& module)
{
    py::class_<NamedContact>(module, "LinkContact")
        .def(pickled<NamedContact,
                     &NamedContact::linkName,
                     &NamedContact::otherLinkName,
                     &NamedContact::obstacle,
                     &NamedContact::gap,
                     &NamedContact::pointLink,
                     &NamedContact::pointOther,
                     &NamedContact::normal,
                     &NamedContact::triangleLink,
                     &NamedContact::triangleOther>())
        .def_readonly("link", &NamedContact::linkName)
        .def_readonly("other_link", &NamedContact::otherLinkName)
        .def_property_readonly(
            "obstacle",
            [](const NamedContact& contact) -> std::optional<std::int32_t>
            { return contact.obstacle == kNone ? std::nullopt : std::optional(contact.obstacle); })
        .def_readonly("gap", &NamedContact::gap)
        .def_property_readonly(
            "point_link", [](const NamedContact& contact) { return arrayOf(contact.pointLink); })
        .def_property_readonly(
            "point_other", [](const NamedContact& contact) { return arrayOf(contact.pointOther); })
        .def_property_readonly("normal",
                               [](const NamedContact& contact) { return arrayOf(contact.normal); })
        .def_readonly("triangle_link", &NamedContact::triangleLink)
        .def_readonly("triangle_other", &NamedContact::triangleOther);
    py::class_<ArticulatedAnswer>(module, "ArticulatedToiResult")
        .def(pickled<ArticulatedAnswer,
                     &ArticulatedAnswer::status,
                     &ArticulatedAnswer::time,
                     &ArticulatedAnswer::contacts>())
        .def_readonly("status", &ArticulatedAnswer::status)
        .def_property_readonly(
            "is_contact", [](const ArticulatedAnswer& answer) { return isContact(answer.status); })
        .def_readonly("time", &ArticulatedAnswer::time)
        .def_readonly("contacts", &ArticulatedAnswer::contacts)
        .def("__repr__",
             [](const ArticulatedAnswer& answer)
             {
                 return py::str("<bullet_ccd.ArticulatedToiResult {}, time {}, {} contacts>")
                     .format(
                         py::cast(answer.status).attr("name"), answer.time, answer.contacts.size());
             });
}
}  // namespace

void addRobots(py::module_& module)
{
    addContactResults(module);
    py::class_<Robot, std::shared_ptr<Robot>>(module, "Robot")
        .def_static(
            "load",
            [](const std::filesystem::path& path)
            {
                const py::gil_scoped_release release;
                return std::make_shared<Robot>(loadRobot(path), std::filesystem::absolute(path));
            },
            py::arg("path"))
        .def(py::pickle([](const Robot& robot) { return py::make_tuple(robot.file.string()); },
                        [](const py::tuple& state)
                        {
                            const std::filesystem::path file = state[0].cast<std::string>();
                            return std::make_shared<Robot>(loadRobot(file), file);
                        }))
        .def_property_readonly("name", [](const Robot& robot) { return robot.model.name; })
        .def_property_readonly("notes", [](const Robot& robot) { return robot.model.notes; })
        .def_property_readonly("link_names", &linkNames)
        .def_property_readonly("link_parents", &linkParents)
        .def_property_readonly("link_joints", &linkJoints)
        .def_property_readonly("joint_names", &jointNames)
        .def_property_readonly("joint_limits", &limitsOf)
        .def("link_poses",
             &linkPosesOf,
             py::arg("positions") = py::none(),
             py::kw_only(),
             py::arg("root") = py::none())
        .def("self_pairs", &selfPairNames)
        .def("__repr__",
             [](const Robot& robot)
             {
                 return py::str("<bullet_ccd.Robot {} with {} joints>")
                     .format(robot.model.name, robot.movable.size());
             });
    const ToiOptions options;
    module.def("articulated_toi",
               &articulatedToiOf,
               py::arg("robot").none(false),
               py::arg("start"),
               py::arg("end"),
               py::arg("obstacles"),
               py::kw_only(),
               py::arg("root_start") = py::none(),
               py::arg("root_end") = py::none(),
               py::arg("self_pairs") = py::list(),
               py::arg("tolerance") = options.tolerance,
               py::arg("minimum_separation") = options.minimumSeparation,
               py::arg("max_iterations") = options.maxIterations,
               py::arg("any_within") = options.anyWithin,
               py::arg("time_limit") = std::numeric_limits<double>::infinity());
}
}  // namespace bullet_ccd::python
