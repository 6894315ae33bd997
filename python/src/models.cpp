#include "bullet_ccd/bullet_ccd.h"
#include "bullet_ccd/reduce/accuracy_costs.h"
#include "bullet_ccd/reduce/reduce_mesh.h"

#include "python/src/arrays.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"

#include <limits>
#include <memory>
#include <optional>
#include <pybind11/stl.h>
#include <stdexcept>
#include <string>

namespace bullet_ccd::python
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A reduced model whose mesh is ready for queries.
struct Model
{
    ReducedModel shape;
    std::shared_ptr<SsvTree> mesh;
};

std::optional<ModelKind> kindOf(const std::optional<std::string>& name)
{
    if (!name)
    {
        return std::nullopt;
    }
    for (const ModelKind kind :
         {ModelKind::Sphere, ModelKind::Capsule, ModelKind::Box, ModelKind::Hull, ModelKind::Mesh})
    {
        if (*name == modelKindName(kind))
        {
            return kind;
        }
    }
    throw py::value_error("kind: '" + *name +
                          "' is no kind of model: give sphere, capsule, box, hull or mesh");
}

std::optional<Model> reduce(const SsvTree& mesh,
                            double accuracy,
                            bool contains,
                            const std::optional<std::string>& kind,
                            double timeLimit)
{
    ReduceOptions options{.accuracy = accuracy, .contains = contains, .kind = kindOf(kind)};
    return answerWithin(timeLimit,
                        [&](const StopCondition& stop) -> std::optional<Model>
                        {
                            options.stop = stop;
                            std::optional<ReducedModel> shape = reduceMesh(mesh.mesh(), options);
                            if (!shape)
                            {
                                return std::nullopt;
                            }
                            auto tree = std::make_shared<SsvTree>(buildSsvTree(shape->mesh));
                            return Model{.shape = std::move(*shape), .mesh = std::move(tree)};
                        });
}

/// The rows that were complete when Ctrl-C came are lost: measuring them takes a minute at most.
std::vector<AccuracyCost> advise(const SsvTree& meshA, const SsvTree& meshB, double timeLimit)
{
    const StopCondition limit = stopAfter(timeLimit);
    std::vector<AccuracyCost> rows;
    const auto work = [&](const std::atomic<bool>& stop)
    {
        rows = measureAccuracies(meshA,
                                 meshB,
                                 [&](std::size_t /*done*/, std::size_t /*all*/)
                                 { return !stop && !limit.isDue(); });
    };
    runInterruptibly(work);
    return rows;
}

void addAccuracies(py::module_& module)
{
    py::class_<AccuracyCost>(module, "AccuracyCost")
        .def_readonly("accuracy", &AccuracyCost::accuracy)
        .def_readonly("model_accuracy", &AccuracyCost::modelAccuracy)
        .def_readonly("minimum_separation", &AccuracyCost::minimumSeparation)
        .def_readonly("tolerance", &AccuracyCost::tolerance)
        .def_readonly("triangles_a", &AccuracyCost::trianglesA)
        .def_readonly("triangles_b", &AccuracyCost::trianglesB)
        .def_readonly("bytes", &AccuracyCost::bytes)
        .def_readonly("reduce_seconds", &AccuracyCost::reduceSeconds)
        .def_readonly("build_seconds", &AccuracyCost::buildSeconds)
        .def_readonly("microseconds", &AccuracyCost::microseconds)
        .def_readonly("warm_microseconds", &AccuracyCost::warmMicroseconds)
        .def_readonly("pairs", &AccuracyCost::pairs)
        .def_readonly("triangles_seen", &AccuracyCost::trianglesSeen)
        .def_readonly("cold_milliseconds", &AccuracyCost::coldMilliseconds)
        .def_readonly("triangles_built", &AccuracyCost::trianglesBuilt)
        .def_readonly("largest_gap", &AccuracyCost::largestGap)
        .def_readonly("contacts", &AccuracyCost::contacts)
        .def_readonly("broken", &AccuracyCost::broken)
        .def("__repr__",
             [](const AccuracyCost& row)
             {
                 return py::str("<bullet_ccd.AccuracyCost {}: {} and {} triangles, {} us>")
                     .format(row.accuracy, row.trianglesA, row.trianglesB, row.microseconds);
             });
    module.def("advise",
               &advise,
               py::arg("mesh_a").none(false),
               py::arg("mesh_b").none(false),
               py::kw_only(),
               py::arg("time_limit") = 50.0);
}
}  // namespace

void addModels(py::module_& module)
{
    py::class_<Deviation>(module, "Deviation")
        .def_readonly("lower", &Deviation::lower)
        .def_readonly("upper", &Deviation::upper)
        .def_property_readonly("point",
                               [](const Deviation& deviation) { return arrayOf(deviation.point); });
    py::class_<Model>(module, "ReducedModel")
        .def_property_readonly("kind",
                               [](const Model& model) { return modelKindName(model.shape.kind); })
        .def_readonly("mesh", &Model::mesh)
        .def_property_readonly("deviation",
                               [](const Model& model) { return model.shape.deviation(); })
        .def_property_readonly("pose", [](const Model& model) { return arrayOf(model.shape.pose); })
        .def_property_readonly("radius", [](const Model& model) { return model.shape.radius; })
        .def_property_readonly("height", [](const Model& model) { return model.shape.height; })
        .def_property_readonly("half_extents",
                               [](const Model& model) { return arrayOf(model.shape.halfExtents); })
        .def("__repr__",
             [](const Model& model)
             {
                 return py::str("<bullet_ccd.ReducedModel {} with {} triangles, deviation {}>")
                     .format(modelKindName(model.shape.kind),
                             model.mesh->mesh().triangles.size(),
                             model.shape.deviation());
             });
    addAccuracies(module);
    module.def("reduce",
               &reduce,
               py::arg("mesh").none(false),
               py::arg("accuracy"),
               py::kw_only(),
               py::arg("contains") = false,
               py::arg("kind") = py::none(),
               py::arg("time_limit") = kInfinity);
    module.def(
        "surface_deviation",
        [](const SsvTree& surface, const SsvTree& other, double enough, double timeLimit)
        {
            return answerWithin(
                timeLimit,
                [&](const StopCondition& stop)
                { return surfaceDeviation(surface.mesh(), other, enough, kInfinity, stop); });
        },
        py::arg("surface").none(false),
        py::arg("other").none(false),
        py::kw_only(),
        py::arg("enough") = 0.0,
        py::arg("time_limit") = kInfinity);
}
}  // namespace bullet_ccd::python
