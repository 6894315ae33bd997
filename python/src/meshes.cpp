#include "bullet_ccd/bullet_ccd.h"
#include "bullet_ccd/io.h"

#include "python/src/arrays.h"
#include "python/src/module.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <pybind11/stl/filesystem.h>
#include <utility>

namespace bullet_ccd::python
{
namespace
{
TriangleMesh meshOf(const py::handle& vertices, const py::handle& triangles)
{
    TriangleMesh mesh;
    mesh.vertices = placesOf(vertices, "vertices");
    const IndexArray indices = indicesOf(triangles, "triangles");
    checkShape(indices, {-1, 3}, "triangles");
    mesh.triangles.resize(static_cast<std::size_t>(indices.shape(0)));
    for (py::ssize_t i = 0; i < indices.shape(0); ++i)
    {
        for (py::ssize_t k = 0; k < 3; ++k)
        {
            // What does not fit is out of range in any case; checkMesh() says so.
            const std::int64_t index = indices.at(i, k);
            const bool fits = index >= 0 && index <= std::numeric_limits<std::int32_t>::max();
            mesh.triangles[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
                fits ? static_cast<std::int32_t>(index) : kNone;
        }
    }
    return mesh;
}

std::shared_ptr<SsvTree> build(TriangleMesh mesh, const std::string& name)
{
    const py::gil_scoped_release release;
    checkMesh(mesh, name);
    return std::make_shared<SsvTree>(buildSsvTree(std::move(mesh)));
}

py::dict massOf(const SsvTree& tree)
{
    const MassProperties mass = massProperties(tree.mesh());
    return py::dict(py::arg("volume") = mass.volume,
                    py::arg("center") = arrayOf(mass.center),
                    py::arg("inertia") = arrayOf(mass.inertia));
}

py::array verticesOf(const py::object& self)
{
    const TriangleMesh& mesh = self.cast<const SsvTree&>().mesh();
    return viewOf(
        mesh.vertices.front().data(), static_cast<py::ssize_t>(mesh.vertices.size()), 3, self);
}

py::array trianglesOf(const py::object& self)
{
    const TriangleMesh& mesh = self.cast<const SsvTree&>().mesh();
    return viewOf(
        mesh.triangles.front().data(), static_cast<py::ssize_t>(mesh.triangles.size()), 3, self);
}

void addMotion(py::module_& module)
{
    py::class_<RigidMotion>(module, "Motion")
        .def(py::init(
                 [](const py::object& pose,
                    const py::object& velocity,
                    const py::object& angularVelocity,
                    const py::object& reference)
                 {
                     return RigidMotion{.X_W0 = poseOf(pose, "pose"),
                                        .v_W = vectorOf(velocity, "velocity"),
                                        .w_W = vectorOf(angularVelocity, "angular_velocity"),
                                        .reference_B = vectorOf(reference, "reference")};
                 }),
             py::arg("pose") = py::none(),
             py::kw_only(),
             py::arg("velocity") = py::make_tuple(0.0, 0.0, 0.0),
             py::arg("angular_velocity") = py::make_tuple(0.0, 0.0, 0.0),
             py::arg("reference") = py::make_tuple(0.0, 0.0, 0.0))
        .def_static(
            "between",
            [](const py::object& start, const py::object& end)
            { return motionBetween(poseOf(start, "start"), poseOf(end, "end")); },
            py::arg("start"),
            py::arg("end"))
        .def_static(
            "screw",
            [](const py::object& start, const py::object& end)
            { return screwBetween(poseOf(start, "start"), poseOf(end, "end")); },
            py::arg("start"),
            py::arg("end"))
        .def(
            "at",
            [](const RigidMotion& motion, double time) { return arrayOf(motion.at(time).X_W); },
            py::arg("time"))
        .def_property_readonly("pose",
                               [](const RigidMotion& motion) { return arrayOf(motion.X_W0); })
        .def_property_readonly("velocity",
                               [](const RigidMotion& motion) { return arrayOf(motion.v_W); })
        .def_property_readonly("angular_velocity",
                               [](const RigidMotion& motion) { return arrayOf(motion.w_W); })
        .def_property_readonly(
            "reference", [](const RigidMotion& motion) { return arrayOf(motion.reference_B); })
        .def(py::pickle(
            [](const RigidMotion& motion)
            {
                return py::make_tuple(arrayOf(motion.X_W0),
                                      arrayOf(motion.v_W),
                                      arrayOf(motion.w_W),
                                      arrayOf(motion.reference_B));
            },
            [](const py::tuple& state)
            {
                return RigidMotion{.X_W0 = poseOf(state[0], "pose"),
                                   .v_W = vectorOf(state[1], "velocity"),
                                   .w_W = vectorOf(state[2], "angular_velocity"),
                                   .reference_B = vectorOf(state[3], "reference")};
            }));
}
}  // namespace

void addMeshes(py::module_& module)
{
    py::class_<SsvTree, std::shared_ptr<SsvTree>>(module, "Mesh")
        .def(
            py::init(
                [](const py::object& vertices, const py::object& triangles, const std::string& name)
                { return build(meshOf(vertices, triangles), name); }),
            py::arg("vertices"),
            py::arg("triangles"),
            py::kw_only(),
            py::arg("name") = "mesh")
        .def_static(
            "load",
            [](const std::filesystem::path& path, double scale)
            {
                TriangleMesh mesh;
                {
                    const py::gil_scoped_release release;
                    mesh = loadMeshFile(path, {.scale = scale}).mesh;
                }
                return build(std::move(mesh), path.string());
            },
            py::arg("path"),
            py::kw_only(),
            py::arg("scale") = 1.0)
        .def_property_readonly("vertices", &verticesOf)
        .def_property_readonly("triangles", &trianglesOf)
        .def_property_readonly("bounds",
                               [](const SsvTree& tree)
                               {
                                   const Eigen::AlignedBox3d box = bounds(tree.mesh());
                                   return py::make_tuple(arrayOf(Eigen::Vector3d(box.min())),
                                                         arrayOf(Eigen::Vector3d(box.max())));
                               })
        .def_property_readonly("is_watertight",
                               [](const SsvTree& tree)
                               {
                                   TriangleMesh mesh = tree.mesh();
                                   repairMesh(mesh);
                                   return isWatertight(mesh);
                               })
        .def("mass_properties", &massOf)
        .def("__repr__",
             [](const SsvTree& tree) {
                 return "<bullet_ccd.Mesh with " + std::to_string(tree.mesh().triangles.size()) +
                        " triangles>";
             })
        // Nothing changes a mesh, so a copy is the same object.
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::object&) { return self; })
        .def(py::pickle([](const py::object& self)
                        { return py::make_tuple(verticesOf(self), trianglesOf(self)); },
                        [](const py::tuple& state)
                        { return build(meshOf(state[0], state[1]), "mesh"); }));
    addMotion(module);
}
}  // namespace bullet_ccd::python
