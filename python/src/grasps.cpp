// Grasps travel between Python and the library as the JSON records of the grasp file, so that there
// is one description of a grasp.
#include "python/src/grasps.h"

#include "bullet_ccd/io.h"

#include "python/src/arrays.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <sstream>
#include <utility>

namespace bullet_ccd::python
{
namespace
{
using grasp::Grasp;

py::dict preshapesOf(const Hand& hand)
{
    py::dict preshapes;
    const std::vector<Link>& links = hand.model.robot.tree.links;
    for (const grasp::Preshape& preshape : hand.model.preshapes)
    {
        py::dict joints;
        for (std::size_t i = 0; i < links.size(); ++i)
        {
            if (links[i].joint.isMovable())
            {
                joints[py::str(links[i].joint.name)] = preshape.positions[i];
            }
        }
        preshapes[py::str(preshape.name)] = joints;
    }
    return preshapes;
}

std::string recordsOf(const Hand& hand,
                      const Object& object,
                      const grasp::PlannerOptions& options,
                      std::span<const Grasp> grasps)
{
    std::ostringstream out;
    grasp::writeGrasps(out,
                       {.handFile = hand.file,
                        .srdfFile = hand.model.srdfFile,
                        .objectFile = object.file,
                        .objectScale = object.scale,
                        .options = options},
                       hand.model,
                       object.model,
                       grasps);
    return out.str();
}

grasp::PlannerOptions optionsOf(double tolerance,
                                double friction,
                                int coneEdges,
                                double threshold,
                                const std::optional<double>& mass)
{
    grasp::PlannerOptions options;
    options.mass = mass;
    options.closing.tolerance = tolerance;
    options.friction = friction;
    options.coneEdges = coneEdges;
    options.forceClosureThreshold = threshold;
    return options;
}

/// The records of all candidates, best first, and whether Ctrl-C ended the plan before its end.
std::pair<std::string, bool> plan(const Hand& hand,
                                  const Object& object,
                                  std::int64_t candidates,
                                  std::uint64_t seed,
                                  int jobs,
                                  double timeLimit,
                                  int volumes,
                                  double tolerance,
                                  double friction,
                                  int coneEdges,
                                  double threshold,
                                  const std::optional<double>& mass,
                                  const std::optional<std::function<void(std::int64_t)>>& progress)
{
    grasp::PlannerOptions options = optionsOf(tolerance, friction, coneEdges, threshold, mass);
    options.candidates = candidates;
    options.seed = seed;
    options.jobs = jobs;
    options.timeLimit = timeLimit;
    options.volumes = volumes;
    std::vector<Grasp> grasps;
    std::atomic<std::int64_t> done = 0;
    std::mutex mutex;  // of progress
    std::optional<py::error_already_set> problem;
    std::atomic<bool> hasProblem = false;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        const auto report = [&](const Grasp&)
        {
            const std::int64_t count = ++done;
            if (!progress || hasProblem)
            {
                return;
            }
            const py::gil_scoped_acquire acquire;
            try
            {
                (*progress)(count);
            }
            catch (py::error_already_set& error)
            {
                problem.emplace(std::move(error));
                hasProblem = true;
            }
        };
        grasps = grasp::planGrasps(
            hand.model,
            object.model,
            options,
            [] { return grasp::kinematicClosing(); },
            {.progress = report, .stop = [&] { return stop.load() || hasProblem.load(); }});
    };
    const bool complete = interruptible(work);
    if (problem)
    {
        throw py::error_already_set(std::move(*problem));
    }
    // The caller raises KeyboardInterrupt with what is complete. Other handlers raise what they
    // like.
    if (!complete && PyErr_ExceptionMatches(PyExc_KeyboardInterrupt) == 0)
    {
        throw py::error_already_set();
    }
    PyErr_Clear();
    return {recordsOf(hand, object, options, grasps), complete};
}

std::string closeAt(const Hand& hand,
                    const Object& object,
                    const py::object& pose,
                    const py::object& shift,
                    const std::optional<std::string>& preshape,
                    double tolerance,
                    double friction,
                    int coneEdges,
                    double threshold,
                    const std::optional<double>& mass)
{
    const Eigen::Isometry3d X_WStart = poseOf(pose, "pose");
    const Eigen::Vector3d way = vectorOf(shift, "shift");
    const grasp::Preshape* start = &hand.model.preshapes.front();
    if (preshape)
    {
        start = findPreshape(hand.model, *preshape);
        if (start == nullptr)
        {
            throw py::key_error(hand.model.robot.name + " has no preshape '" + *preshape + "'");
        }
    }
    const grasp::PlannerOptions options =
        optionsOf(tolerance, friction, coneEdges, threshold, mass);
    const py::gil_scoped_release release;
    const Grasp found = grasp::closeAtPose(
        hand.model, object.model, X_WStart, way, *start, options, grasp::kinematicClosing());
    return recordsOf(hand, object, options, std::span(&found, 1));
}

std::unique_ptr<Hand> loadedHand(const std::filesystem::path& urdf,
                                 const std::optional<std::filesystem::path>& srdf)
{
    const py::gil_scoped_release release;
    return std::make_unique<Hand>(
        Hand{.model = grasp::loadHand(urdf, srdf),
             .file = urdf,
             .srdf = srdf ? std::optional(std::filesystem::absolute(*srdf)) : std::nullopt});
}
}  // namespace

void addGrasps(py::module_& module)
{
    py::class_<Hand>(module, "Hand")
        .def_static(
            "load", &loadedHand, py::arg("urdf"), py::kw_only(), py::arg("srdf") = py::none())
        .def(py::pickle([](const Hand& hand)
                        { return py::make_tuple(std::filesystem::absolute(hand.file), hand.srdf); },
                        [](const py::tuple& state)
                        {
                            return loadedHand(
                                state[0].cast<std::filesystem::path>(),
                                state[1].cast<std::optional<std::filesystem::path>>());
                        }))
        .def_property_readonly("name", [](const Hand& hand) { return hand.model.robot.name; })
        .def_property_readonly("notes", [](const Hand& hand) { return hand.model.notes; })
        .def_property_readonly("finger_names",
                               [](const Hand& hand)
                               {
                                   std::vector<std::string> names;
                                   for (const grasp::Finger& finger : hand.model.fingers)
                                   {
                                       names.push_back(finger.name);
                                   }
                                   return names;
                               })
        .def_property_readonly("preshapes", &preshapesOf)
        .def_property_readonly("grasp_frame",
                               [](const Hand& hand) { return arrayOf(hand.model.X_RG); });
    py::class_<Object>(module, "GraspObject")
        .def(py::init(
                 [](const SsvTree& mesh, const std::string& name)
                 {
                     const py::gil_scoped_release release;
                     return std::make_unique<Object>(
                         Object{.model = grasp::makeGraspObject(name, mesh.mesh()), .file = {}});
                 }),
             py::arg("mesh").none(false),
             py::kw_only(),
             py::arg("name") = "object")
        .def_static(
            "load",
            [](const std::filesystem::path& path, double scale)
            {
                const py::gil_scoped_release release;
                return std::make_unique<Object>(
                    Object{.model = grasp::makeGraspObject(
                               path.stem().string(), loadMeshFile(path, {.scale = scale}).mesh),
                           .file = path,
                           .scale = scale});
            },
            py::arg("path"),
            py::kw_only(),
            py::arg("scale") = 1.0)
        .def(py::pickle(
            [](const Object& object)
            {
                return py::make_tuple(std::make_shared<SsvTree>(object.model.tree),
                                      object.model.name,
                                      object.file.string(),
                                      object.scale);
            },
            [](const py::tuple& state)
            {
                const auto mesh = state[0].cast<std::shared_ptr<SsvTree>>();
                const auto name = state[1].cast<std::string>();
                return std::make_unique<Object>(
                    Object{.model = grasp::makeGraspObject(name, mesh->mesh()),
                           .file = state[2].cast<std::string>(),
                           .scale = state[3].cast<double>()});
            }))
        .def_property_readonly("name", [](const Object& object) { return object.model.name; })
        .def_property_readonly("center_of_mass",
                               [](const Object& object)
                               { return arrayOf(object.model.centerOfMass); })
        .def_property_readonly(
            "usual_mass", [](const Object& object) { return grasp::massOf(object.model).mass; })
        .def_property_readonly("usual_mass_from",
                               [](const Object& object)
                               { return toString(grasp::massOf(object.model).source); })
        .def_property_readonly("is_watertight",
                               [](const Object& object) { return object.model.watertight; });
    const grasp::PlannerOptions options;
    module.def("plan",
               &plan,
               py::arg("hand").none(false),
               py::arg("object").none(false),
               py::kw_only(),
               py::arg("candidates") = options.candidates,
               py::arg("seed") = options.seed,
               py::arg("jobs") = options.jobs,
               py::arg("time_limit") = options.timeLimit,
               py::arg("volumes") = options.volumes,
               py::arg("tolerance") = options.closing.tolerance,
               py::arg("friction") = options.friction,
               py::arg("cone_edges") = options.coneEdges,
               py::arg("force_closure_threshold") = options.forceClosureThreshold,
               py::arg("mass") = py::none(),
               py::arg("progress") = py::none());
    module.def("close_at",
               &closeAt,
               py::arg("hand").none(false),
               py::arg("object").none(false),
               py::arg("pose"),
               py::arg("shift") = py::make_tuple(0.0, 0.0, 0.0),
               py::kw_only(),
               py::arg("preshape") = py::none(),
               py::arg("tolerance") = options.closing.tolerance,
               py::arg("friction") = options.friction,
               py::arg("cone_edges") = options.coneEdges,
               py::arg("force_closure_threshold") = options.forceClosureThreshold,
               py::arg("mass") = py::none());
}
}  // namespace bullet_ccd::python
