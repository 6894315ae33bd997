#include "bullet_ccd/bullet_ccd.h"

#include "python/src/arrays.h"
#include "python/src/interruptible.h"
#include "python/src/module.h"

#include <limits>

namespace bullet_ccd::python
{
namespace
{
const char* kindOf(const ConvexShape& shape)
{
    switch (shape.core)
    {
        case ConvexCore::Point:
            return "point";
        case ConvexCore::Segment:
            return "segment";
        case ConvexCore::Box:
            return "box";
        case ConvexCore::Cylinder:
            return "cylinder";
        case ConvexCore::Cone:
            return "cone";
        case ConvexCore::Hull:
            return "hull";
        case ConvexCore::HalfSpace:
            return "half_space";
    }
    return "";
}

ToiResult convexToiOf(const ConvexShape& shapeA,
                      const ConvexShape& shapeB,
                      const py::object& motionA,
                      const py::object& motionB,
                      double tolerance,
                      double minimumSeparation,
                      std::int64_t maxIterations,
                      double timeLimit)
{
    const ConvexBody a{.shape = &shapeA, .motion = motionOf(motionA, "motion_a")};
    const ConvexBody b{.shape = &shapeB, .motion = motionOf(motionB, "motion_b")};
    return askInterruptibly(stopAfter(timeLimit),
                            [&](const StopCondition& stop)
                            {
                                return convexToi(a,
                                                 b,
                                                 {.tolerance = tolerance,
                                                  .minimumSeparation = minimumSeparation,
                                                  .maxIterations = maxIterations,
                                                  .stop = stop});
                            });
}
}  // namespace

void addConvexShapes(py::module_& module)
{
    py::class_<ConvexShape>(module, "ConvexShape")
        .def_static("sphere", &sphereShape, py::arg("radius"))
        .def_static("capsule", &capsuleShape, py::arg("radius"), py::arg("half_length"))
        .def_static(
            "box",
            [](const py::object& half) { return boxShape(vectorOf(half, "half_extents")); },
            py::arg("half_extents"))
        .def_static("cylinder", &cylinderShape, py::arg("radius"), py::arg("half_length"))
        .def_static("cone", &coneShape, py::arg("radius"), py::arg("half_length"))
        .def_static(
            "hull",
            [](const py::object& points) { return hullShape(placesOf(points, "points")); },
            py::arg("points"))
        .def_static(
            "half_space",
            [](const py::object& normal, double offset)
            { return halfSpaceShape(vectorOf(normal, "normal"), offset); },
            py::arg("normal"),
            py::arg("offset") = 0.0)
        .def("rounded", &ConvexShape::rounded, py::arg("radius"))
        .def_property_readonly("kind", &kindOf)
        .def_readonly("radius", &ConvexShape::radius)
        // Nothing changes a shape, so a copy is the same object.
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::object&) { return self; })
        .def("__repr__",
             [](const ConvexShape& shape) {
                 return py::str("<bullet_ccd.ConvexShape {}, radius {}>")
                     .format(kindOf(shape), shape.radius);
             });
    const ToiOptions options;
    module.def("convex_toi",
               &convexToiOf,
               py::arg("shape_a").none(false),
               py::arg("shape_b").none(false),
               py::arg("motion_a") = py::none(),
               py::arg("motion_b") = py::none(),
               py::kw_only(),
               py::arg("tolerance") = options.tolerance,
               py::arg("minimum_separation") = options.minimumSeparation,
               py::arg("max_iterations") = options.maxIterations,
               py::arg("time_limit") = std::numeric_limits<double>::infinity());
}
}  // namespace bullet_ccd::python
