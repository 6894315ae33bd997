// What holds a grasp: forces, squeezes and simulated trials. Grasps come as their records.
#include "grasp/force/grasp_forces.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/trial/grasp_trial.h"

#include "python/src/arrays.h"
#include "python/src/grasps.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <pybind11/stl.h>
#include <string>
#include <vector>

namespace bullet_ccd::python
{
namespace
{
using grasp::Grasp;

std::vector<std::string> independentNames(const KinematicTree& tree)
{
    std::vector<std::string> names;
    for (const std::int32_t joint : grasp::independentJoints(tree))
    {
        names.push_back(tree.links[static_cast<std::size_t>(joint)].joint.name);
    }
    return names;
}

py::dict byName(const std::vector<std::string>& names, const std::vector<double>& values)
{
    py::dict named;
    for (std::size_t j = 0; j < values.size(); ++j)
    {
        named[py::str(names[j])] = values[j];
    }
    return named;
}

using Efforts = std::map<std::string, double>;

/// The limits with those that were named in their place.
void replaceEfforts(const std::vector<std::string>& names,
                    const Efforts& efforts,
                    std::vector<double>& limits)
{
    for (const auto& [name, limit] : efforts)
    {
        const auto found = std::ranges::find(names, name);
        if (found == names.end())
        {
            throw py::key_error("efforts: the hand has no joint '" + name +
                                "' with a motor of its own");
        }
        limits[static_cast<std::size_t>(found - names.begin())] = limit;
    }
}

grasp::SqueezeOptions squeezeOptions(
    const Hand& hand, double mass, double friction, double firmness, const Efforts& efforts)
{
    grasp::SqueezeOptions options{.mass = mass, .friction = friction, .firmness = firmness};
    if (!efforts.empty())
    {
        for (const grasp::JointEffort& effort : grasp::jointEfforts(hand.model))
        {
            options.efforts.push_back(effort.limit);
        }
        replaceEfforts(independentNames(hand.model.robot.tree), efforts, options.efforts);
    }
    return options;
}

Grasp closedGrasp(const Hand& hand, const std::string& record)
{
    Grasp found = grasp::readGrasp(record, hand.model);
    if (found.positions.empty())
    {
        throw py::value_error("grasp: candidate " + std::to_string(found.candidate) +
                              " never closed (" + toString(found.reject) + "): choose another one");
    }
    return found;
}

py::dict squeeze(const Hand& hand,
                 const std::string& record,
                 double mass,
                 const std::array<double, 3>& centerOfMass,
                 double friction,
                 double firmness,
                 const Efforts& efforts)
{
    const Grasp held = closedGrasp(hand, record);
    grasp::SqueezeOptions options = squeezeOptions(hand, mass, friction, firmness, efforts);
    options.centerOfMass = Eigen::Vector3d(centerOfMass[0], centerOfMass[1], centerOfMass[2]);
    grasp::Squeeze found;
    {
        const py::gil_scoped_release release;
        found = grasp::squeezeOf(hand.model, held, options);
    }
    const std::vector<std::string> names = independentNames(hand.model.robot.tree);
    py::list assumed;
    for (std::size_t j = 0; j < found.efforts.size(); ++j)
    {
        if (found.efforts[j].isAssumed)
        {
            assumed.append(names[j]);
        }
    }
    py::dict answer;
    answer["reason"] = found.exists() ? py::object(py::none()) : py::object(py::str(found.reason));
    answer["torques"] = byName(names, found.torques);
    answer["targets"] = byName(names, found.targets);
    answer["stiffness"] = byName(names, found.stiffness);
    answer["normal_force"] = found.normalForce;
    answer["assumed_efforts"] = assumed;
    return answer;
}

py::dict answerOf(const Hand& hand, const grasp::TrialResult& result)
{
    const bool isLost = result.outcome == grasp::TrialOutcome::Dropped ||
                        result.outcome == grasp::TrialOutcome::Ejected;
    py::list pulls;
    for (const grasp::TrialPull& pull : result.pulls)
    {
        pulls.append(py::make_tuple(
            DoubleArray(6, pull.wrench.data()), pull.size, pull.share, pull.slipped));
    }
    py::dict answer;
    answer["outcome"] = toString(result.outcome);
    answer["reason"] = result.reason.empty() ? py::object(py::none()) : py::str(result.reason);
    answer["slip"] = result.slip;
    answer["turn"] = result.turn;
    answer["lost_at"] = isLost ? py::object(py::float_(result.lostAt)) : py::none();
    answer["peak_force"] = result.peakForce;
    answer["mean_force"] = result.meanForce;
    answer["peak_energy"] = result.peakEnergy;
    answer["peak_torques"] = byName(independentNames(hand.model.robot.tree), result.peakTorques);
    answer["mean_torques"] = byName(independentNames(hand.model.robot.tree), result.meanTorques);
    answer["pulls"] = pulls;
    answer["intersecting_triangles"] = result.penetration.intersectingTriangles;
    answer["penetration"] = result.penetration.deepest;
    answer["simulated_time"] = result.seconds;
    return answer;
}

py::dict trial(const Hand& hand,
               const Object& object,
               const std::string& record,
               const std::string& protocol,
               double mass,
               double friction,
               double firmness,
               const Efforts& efforts,
               const std::optional<double>& surfaceFriction,
               double rate,
               const py::object& up,
               std::uint64_t seed)
{
    const Grasp held = closedGrasp(hand, record);
    const grasp::TrialProtocol what = grasp::namedProtocol(protocol);
    grasp::TrialOptions options{.squeeze = squeezeOptions(hand, mass, friction, firmness, efforts),
                                .friction = surfaceFriction,
                                .rate = rate,
                                .up = vectorOf(up, "up"),
                                .seed = seed};
    grasp::TrialResult result;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        options.stop = {.isCancelled = &stop};
        result = grasp::runTrial(hand.model, object.model, held, what, options);
    };
    runInterruptibly(work);
    return answerOf(hand, result);
}

grasp::ForceObjective objectiveOf(const std::string& name)
{
    if (name == "total")
    {
        return grasp::ForceObjective::Total;
    }
    if (name == "max")
    {
        return grasp::ForceObjective::Max;
    }
    if (name == "firm")
    {
        return grasp::ForceObjective::Firm;
    }
    throw py::value_error("objective: '" + name + "' is none: give total, max or firm");
}

py::dict forces(const Hand& hand,
                const Object& object,
                const std::string& record,
                const py::object& load,
                double friction,
                const std::string& objective,
                const Efforts& efforts)
{
    const Grasp held = closedGrasp(hand, record);
    const DoubleArray wrench = doublesOf(load, "load");
    checkShape(wrench, {6}, "load");
    const KinematicTree& tree = hand.model.robot.tree;
    grasp::ForceProblem problem;
    problem.contacts = held.contacts;
    problem.law.friction = friction;
    problem.load = Eigen::Map<const grasp::Wrench>(wrench.data());
    problem.reference = object.model.centerOfMass;
    problem.torqueLimits = grasp::effortLimits(tree);
    problem.jointNames = independentNames(tree);
    replaceEfforts(problem.jointNames, efforts, problem.torqueLimits);
    const grasp::ForceOptions options{.objective = objectiveOf(objective)};
    grasp::GraspForces found;
    {
        const py::gil_scoped_release release;
        problem.jacobian = grasp::handJacobian(tree, held.X_WH, held.positions, held.contacts);
        found = grasp::solveGraspForces(problem, options);
    }
    py::array_t<double> vectors({static_cast<py::ssize_t>(found.contacts.size()), py::ssize_t{3}});
    for (std::size_t i = 0; i < found.contacts.size(); ++i)
    {
        std::copy_n(found.contacts[i].force.data(),
                    3,
                    vectors.mutable_data(static_cast<py::ssize_t>(i), 0));
    }
    py::dict answer;
    answer["status"] = toString(found.status);
    answer["reason"] = found.reason.empty() ? py::object(py::none()) : py::str(found.reason);
    answer["value"] = found.value;
    answer["bound"] = found.bound;
    answer["contact_forces"] = vectors;
    answer["joint_torques"] = byName(problem.jointNames, found.jointTorques);
    return answer;
}
}  // namespace

void addTrials(py::module_& module)
{
    const grasp::SqueezeOptions squeezing;
    const grasp::TrialOptions options;
    module.def("squeeze",
               &squeeze,
               py::arg("hand").none(false),
               py::arg("record"),
               py::kw_only(),
               py::arg("mass"),
               py::arg("center_of_mass"),
               py::arg("friction") = squeezing.friction,
               py::arg("firmness") = squeezing.firmness,
               py::arg("efforts") = py::dict());
    module.def("trial",
               &trial,
               py::arg("hand").none(false),
               py::arg("object").none(false),
               py::arg("record"),
               py::arg("protocol"),
               py::kw_only(),
               py::arg("mass"),
               py::arg("friction") = squeezing.friction,
               py::arg("firmness") = squeezing.firmness,
               py::arg("efforts") = py::dict(),
               py::arg("surface_friction") = py::none(),
               py::arg("rate") = options.rate,
               py::arg("up") = py::make_tuple(0.0, 0.0, 1.0),
               py::arg("seed") = options.seed);
    module.def("forces",
               &forces,
               py::arg("hand").none(false),
               py::arg("object").none(false),
               py::arg("record"),
               py::arg("load"),
               py::kw_only(),
               py::arg("friction") = squeezing.friction,
               py::arg("objective") = "total",
               py::arg("efforts") = py::dict());
}
}  // namespace bullet_ccd::python
